"""The covering-graph paper's tick: every track is updated once, by its primary sensor."""

from __future__ import annotations

from collections.abc import Callable

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
)
from mctrack_ros.fusion.association.gating import distance, gated_pairs, seen_at, slots
from mctrack_ros.fusion.association.likelihood import differences
from mctrack_ros.fusion.association.scored_pairs import JudgedPairs, judged_pairs
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.association.solvers.covering_graph import flags, shared_out
from mctrack_ros.fusion.config import CoveringConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.measurements.packed import XX, XY, YY, X, Y, measured
from mctrack_ros.fusion.motion.information import gathered
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SPATIAL_WEIGHT, APPEARANCE_WEIGHT = 0.7, 0.3
"""Of the cost in the paper's code."""
APPEARANCE_SCALE = 100.0
"""What it multiplies 1 - Bhattacharyya coefficient by."""
LARGEST_CODE_COST = 100.0
"""A pair that costs more there is none."""
PIXELS_PER_METRE = 50.0
"""What stands for the pixels of its distances: in images of 640 x 480 such as PETS2006's a
person of 1.7 m is about 85 px tall, px/m."""


class CoveringAssociation:
    """
    Associates every track in one image of a tick, without a second thought.

    Section IV.B with what it leaves open: a track's edge needs a valid detection, which is one
    that passes the gate. Where a track is covered by other images than its primary one it is
    *tagged*: among the tracks covered there the exchange shares out what is left, and they count
    as seen, but are not updated. All else of those images that is in the gate of such a track is
    consumed, or it would start duplicates.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp.
    batch : Batch
        The images, in the order of their sensors' priority.
    config : CoveringConfig
        Parameters.

    """

    def __init__(self, table: TrackTable, batch: Batch, config: CoveringConfig) -> None:
        self._single, self._seconds = batch.single, batch.seconds
        self._mean, self._covariance = table.mean, table.covariance
        image = batch.image[batch.single]
        seen = measured(batch.position, batch.noise, batch.single)
        state = table.mean, table.covariance, batch.seconds, seen, image
        track, detection, where, _ = gated_pairs(*state, config.gate)
        squared, metres = _distances(*state, track, detection)
        row = batch.single[detection]
        templates = table.template, batch.detections.template, batch.is_described
        _, difference = differences(*templates, track, row, config.usual_difference)
        cost = COSTS[config.method](squared, metres, difference + config.usual_difference)
        near = np.flatnonzero(cost < np.inf)
        track, detection, where = track[near], detection[near], where[near]
        pairs = Pairs(track, detection, slots(where, track), np.exp(-cost[near] / 2), where)
        self._pairs = pairs
        self._chosen = ASSOCIATORS[config.method]().probabilities(pairs)
        self._told = gathered(
            self._mean,
            self._seconds,
            pairs.image,
            pairs.track,
            pairs.detection,
            self._chosen,
            seen,
        )

    def solve(self) -> Floats:
        """Return what the images tell of the tracks, (n, 13), of each one image at most."""
        return self._told

    def pairs(self) -> tuple[Indices, Indices]:
        """
        Return the tracks (k,) and the detections (k,) that belong together: chosen and tagged.

        Sorted by image, then track.
        """
        pairs, chosen = self._pairs, self._chosen > 0
        taken = np.zeros(len(self._single), np.bool_)
        taken[pairs.detection[chosen]] = True
        others = np.flatnonzero(~flags(pairs) & ~taken[pairs.detection])
        together = chosen.copy()
        together[others] = shared_out(pairs, others)
        return pairs.track[together], self._single[pairs.detection[together]]

    def judged(self, table: TrackTable, batch: Batch, config: CoveringConfig) -> JudgedPairs:
        """Return all pairs with their distance from the prediction: for whoever asks why."""
        pairs, row = self._pairs, self._single[self._pairs.detection]
        track, column = self.pairs()
        together = set(zip(track.tolist(), column.tolist()))
        taken = [pair in together for pair in zip(pairs.track.tolist(), row.tolist())]
        return judged_pairs(
            self._mean,
            self._covariance,
            np.zeros(len(row)),
            self._seconds[pairs.image],
            pairs.track,
            row,
            pairs.slot,
            batch.position[row],
            batch.noise[row],
            self._chosen,
            np.array(taken, np.bool_),
        )

    @property
    def consumed(self) -> Indices:
        """Return the detections (k,) in the gate of tracks whose primary sensor is another."""
        return self._single[self._pairs.detection[~flags(self._pairs)]]


def mahalanobis(squared: Floats, metres: Floats, difference: Floats) -> Floats:
    """Return the cost of the paper's text: the squared Mahalanobis distance."""
    return squared


def code_cost(squared: Floats, metres: Floats, difference: Floats) -> Floats:
    """Return the cost of the paper's code: distance in pixels, and how unlike colours are."""
    spatial, appearance = PIXELS_PER_METRE * metres, APPEARANCE_SCALE * difference
    cost = SPATIAL_WEIGHT * spatial + APPEARANCE_WEIGHT * appearance
    return np.where(cost <= LARGEST_CODE_COST, cost, np.inf)


COSTS: dict[str, Callable[[Floats, Floats, Floats], Floats]] = {
    'covering_graph': mahalanobis,
    'covering_graph_code': code_cost,
}
"""By method: (k,) squared Mahalanobis distances, distances (m) and squared Hellinger distances of
the templates (1 - Bhattacharyya coefficient, the usual one if it is not known) to costs, infinite
where there is no pair."""


@compiled(
    types.Tuple([types.f8[::1], types.f8[::1]])(
        COLUMN_2D, COLUMN_3D, FLOATS_1D, FLOATS_2D, INTS_1D, INTS_1D, INTS_1D
    )
)
def _distances(
    mean: Floats, covariance: Floats, seconds: Floats, seen: Floats, image: Indices,
    track: Indices, detection: Indices,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return the squared Mahalanobis distances (k,) of pairs, and the Euclidean ones, m."""
    squared, metres = np.empty(len(track)), np.empty(len(track))
    for pair in range(len(track)):
        row = detection[pair]
        x, y, xx, xy, yy = seen_at(mean, covariance, track[pair], seconds[image[row]])
        x, y = seen[row, X] - x, seen[row, Y] - y
        xx, xy, yy = xx + seen[row, XX], xy + seen[row, XY], yy + seen[row, YY]
        squared[pair], metres[pair] = distance(x, y, xx, xy, yy)[0], np.hypot(x, y)
    return squared, metres
