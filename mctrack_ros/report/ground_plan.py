"""The pitch as lines on the ground, and a colour for every track."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation import LENGTH_M, WIDTH_M, painted_lines
from mctrack_ros.tracking.colours import track_colour

Floats = NDArray[np.float64]


def pitch_lines() -> list[Floats]:
    """Return the painted lines and the goals, (n, 2) polylines in m, the origin in a corner."""
    goal = np.array([(0, -3.66), (-2.44, -3.66), (-2.44, 3.66), (0, 3.66)])
    goal[:, 1] += WIDTH_M / 2
    return [*painted_lines(), goal, np.array([LENGTH_M, 0.0]) + goal * np.array([-1.0, 1.0])]


def hex_colour(track_id: int) -> str:
    """Return a track's colour as ``#rrggbb``."""
    return '#{:02x}{:02x}{:02x}'.format(*track_colour(track_id))
