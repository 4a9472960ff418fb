"""Homographies and projections between image and ground."""
