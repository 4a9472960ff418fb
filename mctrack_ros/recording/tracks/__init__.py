"""Tracks in files of other tools, one format a module."""
