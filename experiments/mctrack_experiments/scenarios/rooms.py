"""Where the scenarios play: cameras and what they see of the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.scenarios.staged.stage import Rectangle, View

Floats = NDArray[np.float64]

PERSONAL = 0.3
"""Share of somebody's colours that are his own where people can be told apart."""

HALL: Rectangle = (-12.0, -12.0, 12.0, 12.0)
AROUND = (View((-15.0, -12.0), HALL), View((15.0, -12.0), HALL), View((0.0, 18.0), HALL))
"""Three cameras that all see the hall."""

EVERYBODY_ALIKE, TWO_TEAMS = np.zeros(4, np.int64), np.array([0, 1, 0, 1])

LENGTH_M, WIDTH_M = 22.0, 8.0


def corridor(overlap_m: float) -> tuple[View, View]:
    """Return two cameras, each for one half of a way along x; negative: a strip nobody sees."""
    half = overlap_m / 2
    return (
        View((-LENGTH_M - 4, -WIDTH_M), (-LENGTH_M, -WIDTH_M, half, WIDTH_M)),
        View((LENGTH_M + 4, -WIDTH_M), (-half, -WIDTH_M, LENGTH_M, WIDTH_M)),
    )


def turned(places: Floats, angle: float) -> Floats:
    """Return (..., 2) places turned about the middle."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(places @ np.array([[cos, sin], [-sin, cos]]))
