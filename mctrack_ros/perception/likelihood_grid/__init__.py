"""The likelihood-grid paper's camera: edges matched with the outlines of people on a grid."""
