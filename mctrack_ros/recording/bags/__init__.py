"""Bags: read, written, mended."""
