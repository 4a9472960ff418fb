"""Offsets of the cameras' clocks, from targets that move in several views."""
