"""Cameras whose detections lie off those of the others."""
