"""What a target is at most: what says more is not believed; and when time begins anew."""

LARGEST_DISTANCE = 1e6
"""Largest distance from the origin, m."""
LARGEST_VARIANCE = 1e6
"""Variances from which a target is not known at all, m² and m²/s²."""
LARGEST_SPEED = 1e3
"""Highest speed, m/s."""
LARGEST_EXTENT = 100.0
"""Largest extent, m."""

PAUSE_NS = 1_000_000_000
"""Longest gap within one visit, and within one stretch of a path, ns."""
RESTART_NS = 1_000_000_000
"""A stamp that lies before the last one by more than this begins time anew, ns."""


def starts_anew(stamp_ns: int, last_ns: int | None) -> bool:
    """Tell whether time begins anew with a stamp, after the last one or none, ns."""
    return last_ns is not None and stamp_ns < last_ns - RESTART_NS
