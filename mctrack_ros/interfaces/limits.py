"""What a target is at most: what says more is not believed; and when time begins anew."""

LARGEST_DISTANCE = 1e6
"""Nobody is farther than this from the origin, m."""
LARGEST_VARIANCE = 1e6
"""Who is less certain than this is not known at all, m² and m²/s²."""
LARGEST_SPEED = 1e3
"""Nobody is faster, m/s."""
LARGEST_EXTENT = 100.0
"""Nobody is larger, m."""

PAUSE_NS = 1_000_000_000
"""Who is away for longer comes again; who is not seen for longer did not walk in between, ns."""
RESTART_NS = 1_000_000_000
"""A stamp that lies before the last one by more than this begins time anew, ns."""
