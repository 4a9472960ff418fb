"""Sequential belief propagation of Du et al.: the particle filters of a view."""
