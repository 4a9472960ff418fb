"""Covering graph and flag matrix: each track by one sensor, shared out by greedy exchange."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled
from mctrack_ros.fusion.association.solvers.pairs import Pairs

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

NOTHING = -1


class CoveringGraph:
    """
    Every track by its primary sensor alone, as in the covering-graph paper.

    "Real time multiple target tracking using arrayed sensors", section IV. The covering graph C
    has an edge where a track has a valid detection in a sensor's image: a slot each. The flag
    matrix F marks of each track's edges the one to the sensor of the highest priority; images
    are in that order. In each image the tracks that are flagged there share out its detections
    (`exchange`): who is likelier is cheaper, and how much likelier does not matter.
    """

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return ones and zeros, (k,), one at most for a track and for a detection."""
        chosen = np.zeros(len(pairs.slot))
        flagged = np.flatnonzero(flags(pairs))
        chosen[flagged] = shared_out(pairs, flagged)
        return chosen


def covering(pairs: Pairs, images: int, tracks: int) -> Mask:
    """Return the covering matrix C, (images, tracks): who has a valid detection where."""
    matrix = np.zeros((images, tracks), np.bool_)
    matrix[pairs.image, pairs.track] = True
    return matrix


def flags(pairs: Pairs) -> Mask:
    """Return which pairs (k,) are in the primary image of their track: the flag matrix F."""
    primary = np.full(pairs.track.max(initial=NOTHING) + 1, np.iinfo(np.int64).max)
    np.minimum.at(primary, pairs.track, pairs.image)
    return np.asarray(pairs.image == primary[pairs.track])


def shared_out(pairs: Pairs, rows: Indices) -> Mask:
    """Return which of some pairs, (n,) rows, the exchange chooses."""
    slot, detection = pairs.slot[rows], pairs.detection[rows]
    return exchange(slot, detection, pairs.likelihood[rows])[0]


@compiled(types.Tuple([types.b1[::1], types.i8, types.i8])(INTS_1D, INTS_1D, FLOATS_1D))
def exchange(slot: Indices, detection: Indices, likelihood: Floats) -> tuple[Mask, int, int]:
    """
    Resolve conflicts by the iterative greedy exchange of section IV.A.

    Every slot proposes to its best detection. Of several that propose to one, the best keeps it
    and the others go on to their next best, until none has one left to propose to. No slot
    proposes twice to the same detection, so the exchange ends within as many proposals as there
    are pairs, at most slots times detections ("at most K iterations" is not true: of ten slots
    some need thirteen). Of equals the earlier one is the better.

    Parameters
    ----------
    slot, detection : (k,) int64 arrays
        The pairs, sorted by slot.
    likelihood : (k,) array
        How good they are.

    Returns
    -------
    chosen : (k,) bool array
        One pair at most of a slot and of a detection.
    rounds : int
        So often those who had nothing proposed, all at once.
    proposals : int
        So often one of them did.

    """
    count = len(slot)
    chosen = np.zeros(count, np.bool_)
    if count == 0:
        return chosen, 0, 0
    order, begin = np.empty(count, np.int64), np.zeros(slot[-1] + 2, np.int64)
    for pair in range(count):
        begin[slot[pair] + 1] += 1
    begin = np.cumsum(begin)
    for number in range(len(begin) - 1):
        here = slice(begin[number], begin[number + 1])
        order[here] = begin[number] + np.argsort(-likelihood[here], kind='mergesort')
    following, held = begin[:-1].copy(), np.full(len(begin) - 1, NOTHING)
    holder = np.full(detection.max() + 1, NOTHING)
    rounds = proposals = 0
    while True:
        free = np.flatnonzero((held == NOTHING) & (following < begin[1:]))
        if len(free) == 0:
            break
        rounds += 1
        for own in free:
            pair = order[following[own]]
            following[own] += 1
            proposals += 1
            rival = holder[detection[pair]]
            better = rival == NOTHING or likelihood[pair] > likelihood[rival]
            if not better and likelihood[pair] == likelihood[rival]:
                better = pair < rival
            if better:
                if rival != NOTHING:
                    held[slot[rival]] = NOTHING
                holder[detection[pair]], held[own] = pair, pair
    chosen[held[held != NOTHING]] = True
    return chosen, rounds, proposals
