"""Sequential belief propagation of Du et al.: the ground node and the messages."""
