"""Whether a camera has moved since it was calibrated."""
