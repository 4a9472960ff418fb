"""What the pairs of a tick tell of the tracks: the information filter."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_2D,
    COLUMN_3D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.tracking.kalman import inverted

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@inner
def joined(
    first: int, last: int, detection: Indices, probability: Floats,
    position: Floats, information: Floats, weight: Floats, pull: Floats,
) -> bool:  # fmt: skip
    """Join what the pairs of a slot measure: information (2, 2), and it times the place (2,)."""
    weight[:], pull[:] = 0.0, 0.0
    told = False
    for pair in range(first, last):
        share, row = probability[pair], detection[pair]
        if share > 0.0:
            told = True
            for i in range(2):
                for j in range(2):
                    weight[i, j] += share * information[row, i, j]
                    pull[i] += share * information[row, i, j] * position[row, j]
    return told


@inner
def take_out(place: Floats, spread: Floats, weight: Floats, pull: Floats) -> None:
    """Take what measurements have told out of a place (2,) and its spread (2, 2)."""
    rest = np.empty((2, 2))
    inverted(spread, rest)
    inverted(rest - weight, spread)
    spread[0, 1] = spread[1, 0] = (spread[0, 1] + spread[1, 0]) / 2
    x = weight[0, 0] * place[0] + weight[0, 1] * place[1] - pull[0]
    y = weight[1, 0] * place[0] + weight[1, 1] * place[1] - pull[1]
    for i in range(2):
        place[i] += spread[i, 0] * x + spread[i, 1] * y


@inner
def _inverse(matrix: Floats, result: Floats) -> None:
    """Write the inverse of a symmetric positive definite (4, 4) matrix, by blocks."""
    left, rest, mixed, own = (
        np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2)),
    )  # fmt: skip
    inverted(matrix[:2, :2], left)
    for i in range(2):
        for j in range(2):
            mixed[i, j] = left[i, 0] * matrix[0, 2 + j] + left[i, 1] * matrix[1, 2 + j]
    for i in range(2):
        for j in range(2):
            own[i, j] = matrix[2 + i, 2 + j]
            own[i, j] -= matrix[0, 2 + i] * mixed[0, j] + matrix[1, 2 + i] * mixed[1, j]
    own[0, 1] = own[1, 0] = (own[0, 1] + own[1, 0]) / 2
    inverted(own, rest)
    for i in range(2):
        for j in range(2):
            result[2 + i, 2 + j] = rest[i, j]
            cross = -mixed[i, 0] * rest[0, j] - mixed[i, 1] * rest[1, j]
            result[i, 2 + j] = result[2 + j, i] = cross
    for i in range(2):
        for j in range(i, 2):
            value = left[i, j] - result[i, 2] * mixed[j, 0] - result[i, 3] * mixed[j, 1]
            result[i, j] = result[j, i] = value


@compiled(
    types.Tuple([types.f8[:, ::1], types.f8[:, :, ::1]])(
        COLUMN_2D, COLUMN_3D, FLOATS_1D, INTS_1D, INTS_1D, INTS_1D, FLOATS_1D, FLOATS_2D,
        FLOATS_3D,
    )
)  # fmt: skip
def updated(
    mean: Floats, covariance: Floats, seconds: Floats, picture: Indices, track: Indices,
    detection: Indices, probability: Floats, position: Floats, information: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Add what all pairs tell to the predicted states, in the information filter's form."""
    tracks, count = len(mean), len(track)
    told, pulls = np.zeros((tracks, 4, 4)), np.zeros((tracks, 4))
    is_told = np.zeros(tracks, np.bool_)
    weight, pull = np.empty((2, 2)), np.empty(2)
    first = 0
    while first < count:
        last = first + 1
        while last < count and track[last] == track[first] and picture[last] == picture[first]:
            last += 1
        own, later = track[first], seconds[picture[first]]
        if joined(first, last, detection, probability, position, information, weight, pull):
            is_told[own] = True
            for i in range(2):
                gap = pull[i]
                for j in range(2):
                    gap -= weight[i, j] * (mean[own, j] + later * mean[own, 2 + j])
                    told[own, i, j] += weight[i, j]
                    told[own, i, 2 + j] += later * weight[i, j]
                    told[own, 2 + i, j] += later * weight[i, j]
                    told[own, 2 + i, 2 + j] += later**2 * weight[i, j]
                pulls[own, i] += gap
                pulls[own, 2 + i] += later * gap
        first = last
    moved, spread = np.empty((tracks, 4)), np.empty((tracks, 4, 4))
    before = np.empty((4, 4))
    for own in range(tracks):
        moved[own], spread[own] = mean[own], covariance[own]
        if is_told[own]:
            _inverse(covariance[own], before)
            _inverse(before + told[own], spread[own])
            for i in range(4):
                for j in range(4):
                    moved[own, i] += spread[own, i, j] * pulls[own, j]
    return moved, spread
