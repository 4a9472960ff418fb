"""How targets move: a constant-velocity filter, or models that interact."""
