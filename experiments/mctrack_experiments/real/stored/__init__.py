"""Detections that others made: lab6p, CMC, PETS, WILDTRACK."""
