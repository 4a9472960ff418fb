"""Loaders of real data: detections that others made, and truth for the evaluation alone."""
