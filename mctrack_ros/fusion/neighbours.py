"""Pairs of tracks that are near each other on the ground."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_2D, COLUMN_FLAGS, INTS_1D, compiled, inner

Indices = NDArray[np.int64]
NearPairs = tuple[Indices, Indices]


@inner
def cell_slot(x: int, y: int, slots: int) -> int:
    """Return where a cell of a grid is kept, of so many slots, a power of two; cells may share."""
    return (x * 73_856_093 ^ y * 19_349_663) & (slots - 1)


@inner
def is_near(position: NDArray[np.float64], one: int, other: int, distance: float) -> bool:
    """Tell whether two positions are nearer to each other than a distance, m."""
    x, y = position[other, 0] - position[one, 0], position[other, 1] - position[one, 1]
    return bool(x * x + y * y < distance * distance)


def near_pairs(position: NDArray[np.float64], distance: float) -> NearPairs:
    """
    Find the pairs that are nearer to each other than a distance.

    Parameters
    ----------
    position : (n, 2 or more) array
        Ground positions first, m.
    distance : float
        m.

    Returns
    -------
    one, other : (k,) int64 arrays
        Rows, the smaller one first; sorted by it, then by the other.

    """
    return _near_pairs(position, position[:, 0].argsort(), distance)


@compiled(types.Tuple([types.i8[::1], types.i8[::1]])(COLUMN_2D, INTS_1D, types.f8))
def _near_pairs(
    position: NDArray[np.float64], order: Indices, distance: float
) -> tuple[Indices, Indices]:
    """Find them, given the order of the rows along x."""
    count = len(position)
    place = position[order, :2]
    keys = np.empty(4 * count + 16, np.int64)
    found = 0
    for i in range(count):
        for j in range(i + 1, count):
            x = place[j, 0] - place[i, 0]
            if not x < distance:
                break
            y = place[j, 1] - place[i, 1]
            if x * x + y * y < distance * distance:
                if found == len(keys):
                    keys = np.append(keys, np.empty(len(keys), np.int64))
                one, other = order[i], order[j]
                keys[found], found = min(one, other) * count + max(one, other), found + 1
    keys = np.sort(keys[:found])
    return keys // max(count, 1), keys % max(count, 1)


@compiled(types.Tuple([types.i8[::1], types.f8[::1]])(COLUMN_2D, COLUMN_2D, COLUMN_FLAGS))
def nearest(
    position: NDArray[np.float64], others: NDArray[np.float64], wanted: NDArray[np.bool_]
) -> tuple[Indices, NDArray[np.float64]]:
    """
    Find who is nearest to each position (n, 2 or more), of the others (m, 2 or more) wanted (m,).

    Returns
    -------
    row : (n,) int64 array
        The first one of those, among all others; 0 where there is none.
    distance : (n,) array
        Infinite where there is none, m.

    """
    row, squared = np.zeros(len(position), np.int64), np.full(len(position), np.inf)
    candidates = np.flatnonzero(wanted)
    place = np.empty((len(candidates), 2))  # the others are far apart in memory
    for index, other in enumerate(candidates):
        place[index, 0], place[index, 1] = others[other, 0], others[other, 1]
    for one in range(len(position)):
        for index in range(len(candidates)):
            x, y = place[index, 0] - position[one, 0], place[index, 1] - position[one, 1]
            if x * x + y * y < squared[one]:
                row[one], squared[one] = candidates[index], x * x + y * y
    return row, np.sqrt(squared)
