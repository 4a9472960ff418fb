"""Malformed messages, through the codec and into a running graph."""
