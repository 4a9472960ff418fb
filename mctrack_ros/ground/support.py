"""How far outside the points of a calibration a pixel lies, and how much less it is believed."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, INTS_1D, compiled, inner

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OUTSIDE_SHARE = 0.02
"""Standard deviation that a pixel outside a calibration's points is given on top of all else, as
a share of its distance from them, px a px: what the points do not show of the lens."""


def hull_of(points: Floats | None) -> Floats:
    """Return the (k, 2) corners of the convex hull of (n, 2) pixels; none for None."""
    if points is None:
        return np.empty((0, 2))
    return np.asarray(cv2.convexHull(points.astype(np.float32))[:, 0], np.float64)


@inner
def side_of(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Return on which side of the line from a to b a point lies, and twice the area between."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@inner
def distance_squared(corners: Floats, x: float, y: float) -> float:
    """Return the squared distance of a point from a convex polygon; 0 inside, inf if not one."""
    if not (np.isfinite(x) and np.isfinite(y)):
        return np.inf
    count = len(corners)
    left, right = False, False
    for corner in range(count):
        ax, ay = corners[corner]
        bx, by = corners[(corner + 1) % count]
        side = side_of(ax, ay, bx, by, x, y)
        left |= side > 0.0
        right |= side < 0.0
    if not (left and right):
        return 0.0
    best = np.inf
    for corner in range(count):
        ax, ay = corners[corner]
        bx, by = corners[(corner + 1) % count]
        along = (x - ax) * (bx - ax) + (y - ay) * (by - ay)
        share = min(max(along / ((bx - ax) ** 2 + (by - ay) ** 2), 0.0), 1.0)
        away_x, away_y = x - ax - share * (bx - ax), y - ay - share * (by - ay)
        best = min(best, away_x * away_x + away_y * away_y)
    return max(best, 1e-300)


@inner
def doubt(corners: Floats, x: float, y: float) -> float:
    """Return the variance along an axis, px², that a pixel outside a polygon is given."""
    return OUTSIDE_SHARE * OUTSIDE_SHARE * distance_squared(corners, x, y)


@compiled(types.f8[::1](FLOATS_2D, FLOATS_2D))
def doubts(corners: Floats, pixel: Floats) -> Floats:
    """Return the variances along an axis, (n,) px², that pixels outside a polygon are given."""
    variance = np.empty(len(pixel))
    for index in range(len(pixel)):
        variance[index] = doubt(corners, pixel[index, 0], pixel[index, 1])
    return variance


@compiled(types.f8[::1](FLOATS_3D, INTS_1D, FLOATS_2D))
def cell_doubts(corners: Floats, cell: Ints, pixel: Floats) -> Floats:
    """Return the same variances, (n,) px², of pixels outside a cell each."""
    variance = np.empty(len(pixel))
    for index in range(len(pixel)):
        variance[index] = doubt(corners[cell[index]], pixel[index, 0], pixel[index, 1])
    return variance
