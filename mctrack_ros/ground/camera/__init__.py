"""Pinhole cameras with lens distortion, and cameras fitted to clicked points."""
