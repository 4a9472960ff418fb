"""Figures on real data."""
