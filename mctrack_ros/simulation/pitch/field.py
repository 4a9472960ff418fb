"""The football pitch: 105 m x 68 m, origin in a corner, x along it, z up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LENGTH_M = 105.0
WIDTH_M = 68.0
CENTRE_M = np.array([LENGTH_M / 2, WIDTH_M / 2])
LINE_WIDTH_M = 0.12
STRIPE_M = 5.25

_PENALTY_AREA = (16.5, 40.32)
_GOAL_AREA = (5.5, 18.32)
_SPOT_M = 11.0
_CIRCLE_M = 9.15


def landmarks() -> dict[str, tuple[float, float]]:
    """Return the named points of the pitch, m: what a scene file lists (Algorithm 1)."""
    points = {
        'centre': (LENGTH_M / 2, WIDTH_M / 2),
        'halfway_south': (LENGTH_M / 2, 0.0),
        'halfway_north': (LENGTH_M / 2, WIDTH_M),
    }
    for side in ('west', 'east'):
        for end, sign in (('south', -1), ('north', 1)):
            points[f'corner_{side}_{end}'] = (_from_goal(0.0, side), WIDTH_M / 2 * (1 + sign))
            for name, (depth, breadth) in (('penalty', _PENALTY_AREA), ('goal', _GOAL_AREA)):
                y = WIDTH_M / 2 + sign * breadth / 2
                points[f'{name}_area_{side}_{end}'] = (_from_goal(depth, side), y)
        points[f'penalty_spot_{side}'] = (_from_goal(_SPOT_M, side), WIDTH_M / 2)
    return points


def line_distance(x: Floats, y: Floats) -> Floats:
    """
    Return the distance to the nearest painted line's middle, m.

    Parameters
    ----------
    x, y : arrays of one shape
        Ground positions, m.

    """
    mirrored_x = np.minimum(x, LENGTH_M - x)
    from_axis = np.abs(y - WIDTH_M / 2)
    distance = np.minimum(
        _box(mirrored_x - LENGTH_M / 2, from_axis, LENGTH_M / 2, WIDTH_M / 2),
        np.where(from_axis <= WIDTH_M / 2, np.abs(x - LENGTH_M / 2), np.inf),
    )
    for depth, breadth in (_PENALTY_AREA, _GOAL_AREA):
        distance = np.minimum(distance, _box(mirrored_x, from_axis, depth, breadth / 2))
    circle = np.hypot(x - LENGTH_M / 2, y - WIDTH_M / 2)
    spot = np.hypot(mirrored_x - _SPOT_M, from_axis)
    arc = np.where(mirrored_x > _PENALTY_AREA[0], np.abs(spot - _CIRCLE_M), np.inf)
    distance = np.minimum(np.minimum(distance, np.abs(circle - _CIRCLE_M)), arc)
    dots = np.minimum(circle, spot) - 0.1
    return np.minimum(distance, np.maximum(dots, 0.0))


def painted_lines() -> list[Floats]:
    """Return the middles of the painted lines, (n, 2) polylines in m."""
    half = [
        _before_goal(*_PENALTY_AREA),
        _before_goal(*_GOAL_AREA),
        _arc((_SPOT_M, WIDTH_M / 2), float(np.arccos((_PENALTY_AREA[0] - _SPOT_M) / _CIRCLE_M))),
    ]
    corners = np.array(
        [(0, 0), (LENGTH_M, 0), (LENGTH_M, WIDTH_M), (0, WIDTH_M), (0, 0)], np.float64
    )
    return [
        corners,
        np.array([(LENGTH_M / 2, 0), (LENGTH_M / 2, WIDTH_M)]),
        _arc((LENGTH_M / 2, WIDTH_M / 2), np.pi),
        *half,
        *(np.array([LENGTH_M, 0]) + line * np.array([-1, 1]) for line in half),
    ]


def is_light_stripe(x: Floats) -> NDArray[np.bool_]:
    """Return where the mown stripe is one of the lighter ones."""
    return np.asarray(np.floor(x / STRIPE_M) % 2 == 0)


def beyond_edge(x: Floats, y: Floats) -> Floats:
    """Return how far outside the touch lines a place is, m; 0 on the pitch."""
    outside_x = np.maximum(np.maximum(-x, x - LENGTH_M), 0)
    outside_y = np.maximum(np.maximum(-y, y - WIDTH_M), 0)
    return np.asarray(np.hypot(outside_x, outside_y))


def _from_goal(depth: float, side: str) -> float:
    return depth if side == 'west' else LENGTH_M - depth


def _before_goal(depth: float, breadth: float) -> Floats:
    """Return three sides of a box before the western goal, (4, 2) m."""
    low, high = (WIDTH_M - breadth) / 2, (WIDTH_M + breadth) / 2
    return np.array([(0, low), (depth, low), (depth, high), (0, high)])


def _arc(middle: tuple[float, float], reach: float) -> Floats:
    """Return a part of a circle of the pitch about the x axis, (49, 2) m."""
    angle = np.linspace(-reach, reach, 49)
    return np.asarray(middle + _CIRCLE_M * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def _box(x: Floats, y: Floats, half_x: float, half_y: float) -> Floats:
    """Return the distance to the outline of a box about the origin."""
    outside_x, outside_y = np.abs(x) - half_x, np.abs(y) - half_y
    inside = np.abs(np.minimum(np.maximum(outside_x, outside_y), 0))
    return np.asarray(np.hypot(np.maximum(outside_x, 0), np.maximum(outside_y, 0)) + inside)
