"""What cameras see of the ground, alone and together."""
