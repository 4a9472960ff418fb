"""Calibration files: one format a module, read and written."""
