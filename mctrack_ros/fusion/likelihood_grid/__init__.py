"""The likelihood-grid paper's fusion: product over cameras, local maxima, nearest neighbours."""
