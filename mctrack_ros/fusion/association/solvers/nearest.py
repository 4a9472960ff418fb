"""Nearest neighbour: every track takes what fits it best."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled
from mctrack_ros.fusion.association.solvers.pairs import Pairs

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class NearestNeighbour:
    """
    The nearest-neighbour standard filter: the likeliest detection of each slot is certainly its.

    Two tracks may take the same one (Bar-Shalom and Fortmann 1988, "Tracking and Data
    Association"; what the covering-graph paper compares itself with).
    """

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return ones and zeros, (k,)."""
        return _nearest(pairs.slot, pairs.likelihood)


@compiled(types.f8[::1](INTS_1D, FLOATS_1D))
def _nearest(slot: Indices, likelihood: Floats) -> Floats:
    chosen = np.zeros(len(slot))
    first = 0
    while first < len(slot):
        last, best = first + 1, first
        while last < len(slot) and slot[last] == slot[first]:
            if likelihood[last] > likelihood[best]:
                best = last
            last += 1
        if likelihood[best] > 1.0:
            chosen[best] = 1.0
        first = last
    return chosen
