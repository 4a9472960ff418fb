"""Whether a track exists: what cameras see of it against what they should see."""
