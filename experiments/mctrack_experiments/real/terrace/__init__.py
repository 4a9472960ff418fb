"""EPFL's terrace: four cameras, two videos, and live."""
