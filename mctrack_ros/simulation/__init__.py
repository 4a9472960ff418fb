"""Synthetic scenes and cameras with exact truth."""
