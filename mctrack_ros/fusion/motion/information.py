"""What the pairs of a tick measure of the tracks: the information filter."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_2D,
    COLUMN_3D,
    FLOATS_1D,
    FLOATS_2D,
    INTS_1D,
    compiled,
    inlined,
    inner,
)
from mctrack_ros.fusion.measurements.packed import OF_XX, OF_XY, OF_YY, X, Y, inverted

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

INFORMATION_SIZE = 13
"""Number of values that a tick measures of a track, see `gathered`."""


@inlined
def joined(
    first: int, last: int, detection: Indices, probability: Floats, seen: Floats
) -> tuple[bool, float, float, float, float, float]:
    """
    Join what the pairs of a slot measure.

    Returns
    -------
    reported : bool
        Whether they say anything.
    xx, xy, yy : float
        Their information, 1/m².
    x, y : float
        That times the place, 1/m.

    """
    reported, xx, xy, yy, x, y = False, 0.0, 0.0, 0.0, 0.0, 0.0
    for pair in range(first, last):
        share, row = probability[pair], detection[pair]
        if share > 0.0:
            reported = True
            own_xx, own_yy = share * seen[row, OF_XX], share * seen[row, OF_YY]
            own_xy = share * seen[row, OF_XY]
            xx, xy, yy = xx + own_xx, xy + own_xy, yy + own_yy
            x = x + own_xx * seen[row, X] + own_xy * seen[row, Y]
            y = y + own_xy * seen[row, X] + own_yy * seen[row, Y]
    return reported, xx, xy, yy, x, y


@inner
def without(
    x: float, y: float, xx: float, xy: float, yy: float,
    weight_xx: float, weight_xy: float, weight_yy: float, pull_x: float, pull_y: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Take measurements out of a place and its covariance."""
    own_xx, own_xy, own_yy = inverted(xx, xy, yy)
    xx, xy, yy = inverted(own_xx - weight_xx, own_xy - weight_xy, own_yy - weight_yy)
    back_x = weight_xx * x + weight_xy * y - pull_x
    back_y = weight_xy * x + weight_yy * y - pull_y
    return x + (xx * back_x + xy * back_y), y + (xy * back_x + yy * back_y), xx, xy, yy


@inner
def invert(matrix: Floats, result: Floats) -> float:
    """
    Write the inverse of a symmetric positive definite (4, 4) matrix, by blocks.

    Returns the inverse's determinant.
    """
    xx, xy, yy = inverted(matrix[0, 0], matrix[0, 1], matrix[1, 1])
    mixed_00 = xx * matrix[0, 2] + xy * matrix[1, 2]
    mixed_01 = xx * matrix[0, 3] + xy * matrix[1, 3]
    mixed_10 = xy * matrix[0, 2] + yy * matrix[1, 2]
    mixed_11 = xy * matrix[0, 3] + yy * matrix[1, 3]
    own_xx, own_xy, own_yy = inverted(
        matrix[2, 2] - (matrix[0, 2] * mixed_00 + matrix[1, 2] * mixed_10),
        matrix[2, 3] - (matrix[0, 2] * mixed_01 + matrix[1, 2] * mixed_11),
        matrix[3, 3] - (matrix[0, 3] * mixed_01 + matrix[1, 3] * mixed_11),
    )
    cross_00 = -mixed_00 * own_xx - mixed_01 * own_xy
    cross_01 = -mixed_00 * own_xy - mixed_01 * own_yy
    cross_10 = -mixed_10 * own_xx - mixed_11 * own_xy
    cross_11 = -mixed_10 * own_xy - mixed_11 * own_yy
    result[2, 2], result[3, 3] = own_xx, own_yy
    result[2, 3] = result[3, 2] = own_xy
    result[0, 2] = result[2, 0] = cross_00
    result[0, 3] = result[3, 0] = cross_01
    result[1, 2] = result[2, 1] = cross_10
    result[1, 3] = result[3, 1] = cross_11
    result[0, 0] = xx - cross_00 * mixed_00 - cross_01 * mixed_01
    result[0, 1] = result[1, 0] = xy - cross_00 * mixed_10 - cross_01 * mixed_11
    result[1, 1] = yy - cross_10 * mixed_10 - cross_11 * mixed_11
    return float((xx * yy - xy * xy) * (own_xx * own_yy - own_xy * own_xy))


@inner
def _note(
    reported: Floats, own: int, later: float,
    xx: float, xy: float, yy: float, x: float, y: float,
) -> None:  # fmt: skip
    """Add what one image measured of a track to that of all, (n, 13)."""
    square = later**2
    reported[own, 0] += xx
    reported[own, 1] += xy
    reported[own, 2] += yy
    reported[own, 3] += later * xx
    reported[own, 4] += later * xy
    reported[own, 5] += later * yy
    reported[own, 6] += square * xx
    reported[own, 7] += square * xy
    reported[own, 8] += square * yy
    reported[own, 9] += x
    reported[own, 10] += y
    reported[own, 11] += later * x
    reported[own, 12] += later * y


@inner
def add(reported: Floats, matrix: Floats) -> None:
    """Add the measured information of a track to its own, (4, 4)."""
    for block in range(3):
        row, column = block // 2, (block + 1) // 2
        xx, xy, yy = reported[3 * block], reported[3 * block + 1], reported[3 * block + 2]
        row, column = 2 * row, 2 * column
        matrix[row, column] += xx
        matrix[row, column + 1] += xy
        matrix[row + 1, column] += xy
        matrix[row + 1, column + 1] += yy


@compiled(types.f8[:, ::1](COLUMN_2D, FLOATS_1D, INTS_1D, INTS_1D, INTS_1D, FLOATS_1D, FLOATS_2D))
def gathered(
    mean: Floats, seconds: Floats, image: Indices, track: Indices, detection: Indices,
    probability: Floats, seen: Floats,
) -> Floats:  # fmt: skip
    """
    Gather what the pairs of a tick measure of the tracks.

    Parameters
    ----------
    mean : (n, 4) array
        Predicted x, y, vx, vy of the tracks; m and m/s.
    seconds : (images,) array
        From the tracks' stamp to each image's, s.
    image, track, detection : (k,) int64 arrays
        Of which each pair is; sorted by image, then track.
    probability : (k,) array
        How much each counts.
    seen : (m, 8) array
        What the detections say, see `measured`.

    Returns
    -------
    (n, 13) array
        Information of the place, of place and velocity, of the velocity, each xx, xy, yy; then
        what it pulls the four components of the state by, from the mean.

    """
    reported, count, first = np.zeros((len(mean), INFORMATION_SIZE)), len(track), 0
    while first < count:
        last = first + 1
        while last < count and track[last] == track[first] and image[last] == image[first]:
            last += 1
        own, later = track[first], seconds[image[first]]
        has_information, xx, xy, yy, x, y = joined(first, last, detection, probability, seen)
        if has_information:
            there_x = mean[own, 0] + later * mean[own, 2]
            there_y = mean[own, 1] + later * mean[own, 3]
            x, y = x - xx * there_x - xy * there_y, y - xy * there_x - yy * there_y
            _note(reported, own, later, xx, xy, yy, x, y)
        first = last
    return reported


@compiled(types.Tuple([types.f8[:, ::1], types.f8[:, :, ::1]])(COLUMN_2D, COLUMN_3D, FLOATS_2D))
def updated(mean: Floats, covariance: Floats, reported: Floats) -> tuple[Floats, Floats]:
    """Add what was measured (see `gathered`) to predicted states, by the information filter."""
    moved, spread = np.empty(mean.shape), np.empty(covariance.shape)
    before = np.empty((4, 4))
    for own in range(len(mean)):
        if reported[own, 0] > 0.0:
            invert(covariance[own], before)
            add(reported[own], before)
            invert(before, spread[own])
            for i in range(4):
                value = mean[own, i]
                for j in range(4):
                    value += spread[own, i, j] * reported[own, 9 + j]
                moved[own, i] = value
        else:
            for i in range(4):
                moved[own, i] = mean[own, i]
                for j in range(4):
                    spread[own, i, j] = covariance[own, i, j]
    return moved, spread
