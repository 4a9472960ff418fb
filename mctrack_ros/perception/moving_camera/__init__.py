"""The calibration of a camera that pans, tilts and zooms, from image to image."""
