"""Experiments I and II of the event-tracking paper: how exact mappings to the ground are."""
