"""Joint probabilistic data association: all joint assignments, each as far as it is probable."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled, inner
from mctrack_ros.fusion.association.solvers.belief import LARGEST, beliefs
from mctrack_ros.fusion.association.solvers.pairs import Pairs, components, counted, numbered

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_EXACT = 8
"""A part of the graph is solved exactly up to so many slots, or up to so many detections."""


class JointProbabilisticData:
    """
    JPDA: exact in small connected parts of the graph, by belief propagation in large ones.

    The exact sum runs over sets of detections (or of slots, if they are fewer) instead of joint
    assignments: what is left to a slot depends only on which ones are used already (Fortmann,
    Bar-Shalom and Scheffe 1983, "Sonar tracking of multiple targets using joint probabilistic data
    association").
    """

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return the (k,) probabilities; with the missed detection a slot's sum to 1."""
        return _joint(pairs.slot, pairs.detection, pairs.likelihood)


@inner
def _marginals(row: Indices, bit: Indices, rows: int, bits: int, likelihood: Floats) -> Floats:
    """
    Return the exact probabilities of a part's pairs (k,).

    ``before[r, set]`` is the sum over the joint assignments of the rows up to `r` that use just
    that set of the other side, ``after[r, set]`` over those of the rows from `r` on that use
    nothing of it.
    """
    before, after = np.zeros((rows + 1, 1 << bits)), np.ones((rows + 1, 1 << bits))
    before[0, 0] = 1.0
    for r in range(rows):
        before[r + 1] = before[r]
        for pair in range(len(row)):
            if row[pair] == r:
                own = 1 << bit[pair]
                for used in range(1 << bits):
                    if not used & own:
                        before[r + 1, used | own] += likelihood[pair] * before[r, used]
    for r in range(rows - 1, -1, -1):
        after[r] = after[r + 1]
        for pair in range(len(row)):
            if row[pair] == r:
                own = 1 << bit[pair]
                for used in range(1 << bits):
                    if not used & own:
                        after[r, used] += likelihood[pair] * after[r + 1, used | own]
    probability = np.empty(len(row))
    for pair in range(len(row)):
        own, total = 1 << bit[pair], 0.0
        for used in range(1 << bits):
            if not used & own:
                total += before[row[pair], used] * after[row[pair] + 1, used | own]
        probability[pair] = likelihood[pair] * total / after[0, 0]
    return probability


@inner
def _is_star(end: Indices, pairs: Indices) -> bool:
    """Tell whether all pairs have one of their ends in common: only one of them can be true."""
    for pair in pairs:  # noqa: SIM110 - not compiled otherwise
        if end[pair] != end[pairs[0]]:
            return False
    return True


@compiled(types.f8[::1](INTS_1D, INTS_1D, FLOATS_1D))
def _joint(slot: Indices, detection: Indices, likelihood: Floats) -> Floats:
    """Solve the small parts of the graph one by one, and all large ones together."""
    count = len(slot)
    part = components(slot, detection)
    order = counted(part, part.max() + 1 if count else 0)
    probability, is_large = np.empty(count), np.zeros(count, np.bool_)
    slots, detections = np.empty(count, np.int64), np.empty(count, np.int64)
    likelihood = np.minimum(likelihood, LARGEST)
    first = 0
    while first < count:
        last = first + 1
        while last < count and part[order[last]] == part[order[first]]:
            last += 1
        here = order[first:last]
        first = last
        if _is_star(slot, here) or _is_star(detection, here):
            none = 1.0
            for pair in here:
                none += likelihood[pair]
            for pair in here:
                probability[pair] = likelihood[pair] / none
            continue
        rows = numbered(slot, here, slots[: len(here)])
        bits = numbered(detection, here, detections[: len(here)])
        one, other = slots[: len(here)], detections[: len(here)]
        if bits > min(rows, MOST_EXACT):
            one, other, rows, bits = other, one, bits, rows
        if bits <= MOST_EXACT:
            probability[here] = _marginals(one, other, rows, bits, likelihood[here])
        else:
            is_large[here] = True
    large = np.flatnonzero(is_large)
    if len(large):
        number = np.searchsorted(np.unique(slot[large]), slot[large])
        probability[large] = beliefs(number, detection[large], likelihood[large])
    return probability
