"""Global nearest neighbour: the likeliest one-to-one assignment."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.association.solvers.pairs import Pairs, components, numbered

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

NOTHING = -1


class GlobalNearestNeighbour:
    """GNN: of all joint assignments the likeliest one is certainly true."""

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return ones and zeros, (k,), one at most for a slot and for a detection."""
        gain = np.log(np.maximum(pairs.likelihood, 1e-300))
        alone = _is_alone(pairs.slot) & _is_alone(pairs.detection)
        chosen = np.where(alone & (gain > 0), 1.0, 0.0)
        rest = np.flatnonzero(~alone & (gain > 0))
        if len(rest):
            chosen[rest] = _assigned(pairs.slot[rest], pairs.detection[rest], gain[rest])
        return chosen


class WeighedNearestNeighbour:
    """
    GNN whose pairs count for as much as they are probable.

    Each competes with all that share its slot or its detection, and with there being no pair
    (Fitzgerald 1986, "Development of practical PDA logic for multitarget tracking by
    microprocessor"). Where it is in doubt who is who, tracks so move little, and as nothing is
    averaged they do not run together, as those of JPDA do.
    """

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return the (k,) probabilities, one at most for a slot and for a detection not 0."""
        own = pairs.likelihood
        slots = np.bincount(pairs.slot, own)[pairs.slot]
        detections = np.bincount(pairs.detection, own)[pairs.detection]
        chosen = GlobalNearestNeighbour().probabilities(pairs)
        return np.asarray(chosen * own / (1.0 + slots + detections - own))


def _is_alone(part: Indices) -> NDArray[np.bool_]:
    """Return which (k,) have a part, a slot or a detection, for themselves."""
    return np.asarray(np.bincount(part)[part] == 1)


def _assigned(slot: Indices, detection: Indices, gain: Floats) -> Floats:
    """Solve each connected part of the graph by itself; all gains are above 0."""
    part = components(slot, detection)
    order, ends = part.argsort(kind='stable'), np.bincount(part).cumsum()
    row, column = _numbered(order, ends, slot, detection)
    chosen = np.zeros(len(gain))
    for first, last in pairwise([0, *ends.tolist()]):
        pairs, rows, columns = order[first:last], row[first:last], column[first:last]
        block = np.zeros((rows.max() + 1, columns.max() + 1))
        block[rows, columns] = gain[pairs]
        partner = np.full(len(block), NOTHING)
        taken, taken_column = linear_sum_assignment(block, maximize=True)
        partner[taken] = taken_column
        chosen[pairs] = partner[rows] == columns
    return chosen


@compiled(types.Tuple([types.i8[::1]] * 2)(INTS_1D, INTS_1D, INTS_1D, INTS_1D))
def _numbered(
    order: Indices, ends: Indices, slot: Indices, detection: Indices
) -> tuple[Indices, Indices]:
    """
    Give slots and detections numbers within their connected part.

    Parameters
    ----------
    order : (k,) array
        The pairs, sorted by part.
    ends : (parts,) array
        Where each part ends there.
    slot, detection : (k,) arrays
        Of the pairs, as they were.

    Returns
    -------
    row, column : (k,) arrays
        In that order.

    """
    row, column = np.empty(len(order), np.int64), np.empty(len(order), np.int64)
    first = 0
    for last in ends:
        numbered(slot, order[first:last], row[first:last])
        numbered(detection, order[first:last], column[first:last])
        first = last
    return row, column
