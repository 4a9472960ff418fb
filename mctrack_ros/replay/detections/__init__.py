"""What somebody's own detectors saw, put on the ground."""
