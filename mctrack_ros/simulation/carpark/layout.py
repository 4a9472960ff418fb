"""The car park: two driving lanes, three rows of bays, a pavement, a footway, a camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera, looking_at
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]

LENGTH_M, WIDTH_M = 40.0, 31.0
"""What is surveyed, from the origin in the corner that is near and to the left."""

BAY_WIDTH_M, BAY_DEPTH_M = 2.6, 5.0
LANES_Y = (8.25, 24.75)
"""Middles of the two driving lanes, m."""

PAVEMENT_Y, FOOTWAY_Y = (-3.0, -0.4), (28.6, 30.8)
"""Where only pedestrians walk, nearest and farthest from the camera, m."""

FAR_LEFT_M, FAR_RIGHT_M = -6.0, 46.0
"""Beyond the image's edges on every lane."""

_FIRST_BAY_X, _BAYS = 3.1, 14
_ROWS = ((0.2, 1, 0), (11.5, -1, 0), (16.5, 1, 1))


@dataclass(frozen=True, slots=True)
class Bay:
    """
    A parking place.

    Attributes
    ----------
    x, y : float
        Its middle, m.
    lane : int
        The lane it opens to.
    towards : int
        +1: the lane lies at larger y, -1: at smaller y.

    """

    x: float
    y: float
    lane: int
    towards: int


def bays() -> tuple[Bay, ...]:
    """Return all bays, row by row."""
    return tuple(
        Bay(_FIRST_BAY_X + BAY_WIDTH_M * column, low + BAY_DEPTH_M / 2, lane, towards)
        for low, towards, lane in _ROWS
        for column in range(_BAYS)
    )


def gaps_x() -> Floats:
    """Return the lines between bays, on which people walk between parked cars, m."""
    return np.asarray(_FIRST_BAY_X + BAY_WIDTH_M * (np.arange(_BAYS + 1) - 0.5))


def carpark_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """Return the one camera, on a building 10.5 m above the ground (silhouettes, section 6)."""
    middle = LENGTH_M / 2
    return (looking_at('cam1', (middle, -20.0, 10.5), (middle, 12.0, 0.0), 1050, scenario),)


def landmarks() -> dict[str, tuple[float, float]]:
    """Return named places that a surveyor would mark: corners of rows of bays, m."""
    left, right = gaps_x()[[0, -1]].tolist()
    points = {}
    for name, (low, *_) in zip(('near', 'middle', 'far'), _ROWS):
        for side, x in (('left', left), ('right', right)):
            points[f'{name}_row_{side}'] = (x, low)
            points[f'{name}_row_{side}_back'] = (x, low + BAY_DEPTH_M)
    return points


def painted(x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return where the white lines between bays are."""
    column = (x - gaps_x()[0]) / BAY_WIDTH_M
    near_line = np.abs(column - np.round(column)) * BAY_WIDTH_M < 0.06
    between = (np.round(column) >= 0) & (np.round(column) <= _BAYS)
    rows = np.zeros(np.shape(x), np.bool_)
    for low, *_ in _ROWS:
        rows |= (y > low) & (y < low + BAY_DEPTH_M)
    return np.asarray(near_line & between & rows)
