"""The pitch as lines on the ground, and a colour for every track."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation import LENGTH_M, WIDTH_M
from mctrack_ros.tracking.colours import track_colour

Floats = NDArray[np.float64]

_CIRCLE_M = 9.15
_SPOT_M = 11.0


def pitch_lines() -> list[Floats]:
    """Return the painted lines, (n, 2) polylines in m, the origin in a corner."""
    middle = np.array([LENGTH_M / 2, WIDTH_M / 2])
    half = [
        _box(0.0, WIDTH_M / 2 - 20.16, 16.5, 40.32),
        _box(0.0, WIDTH_M / 2 - 9.16, 5.5, 18.32),
        _box(-2.44, WIDTH_M / 2 - 3.66, 2.44, 7.32),
        _penalty_arc(),
    ]
    mirrored = [np.array([LENGTH_M, 0.0]) + line * np.array([-1.0, 1.0]) for line in half]
    return [
        _box(0.0, 0.0, LENGTH_M, WIDTH_M),
        np.array([[LENGTH_M / 2, 0.0], [LENGTH_M / 2, WIDTH_M]]),
        middle + _CIRCLE_M * _directions(0.0, 2 * np.pi),
        *half,
        *mirrored,
    ]


def hex_colour(track_id: int) -> str:
    """Return a track's colour as ``#rrggbb``."""
    return '#{:02x}{:02x}{:02x}'.format(*track_colour(track_id))


def _box(left: float, bottom: float, length: float, breadth: float) -> Floats:
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]], np.float64)
    return np.asarray(np.array([left, bottom]) + corners * np.array([length, breadth]))


def _penalty_arc() -> Floats:
    reach = np.arccos((16.5 - _SPOT_M) / _CIRCLE_M)
    return np.array([_SPOT_M, WIDTH_M / 2]) + _CIRCLE_M * _directions(-reach, reach)


def _directions(start: float, stop: float) -> Floats:
    angle = np.linspace(start, stop, 49)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
