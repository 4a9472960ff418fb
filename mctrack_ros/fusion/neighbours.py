"""Pairs of tracks that are near each other on the ground."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.compiled import COLUMN_2D, INTS_1D, compiled, inner

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
    count = max(len(position), 1)
    keys = _near_pairs(position, position[:, 0].argsort(), distance)
    keys.sort()
    return keys // count, keys % count


@compiled(types.i8[::1](COLUMN_2D, INTS_1D, types.f8))
def _near_pairs(position: NDArray[np.float64], order: Indices, distance: float) -> Indices:
    """Return a number (k,) for each pair, given the order of the rows along x."""
    count = len(position)
    keys, found = np.empty(4 * count + 16, np.int64), 0
    for i in range(count):
        for j in range(i + 1, count):
            one, other = order[i], order[j]
            if not position[other, 0] - position[one, 0] < distance:
                break
            if is_near(position, one, other, distance):
                if found == len(keys):
                    keys = grown(keys, 2 * found)
                keys[found], found = min(one, other) * count + max(one, other), found + 1
    return keys[:found]


@inner
def grown(values: Indices, size: int) -> Indices:
    """Return an array of a larger size that begins with these values."""
    longer = np.empty(size, np.int64)
    for index in range(len(values)):
        longer[index] = values[index]
    return longer


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
    candidates = wanted.nonzero()[0]
    if not len(candidates):
        return np.zeros(len(position), np.int64), np.full(len(position), np.inf)
    apart = cdist(position[:, :2], others[candidates, :2])
    closest = apart.argmin(axis=1)
    return candidates[closest], apart[range(len(apart)), closest]
