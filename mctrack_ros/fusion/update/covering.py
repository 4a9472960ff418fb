"""The covering-graph paper's tick: every track is updated once, by its primary sensor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.config import CoveringConfig
from mctrack_ros.fusion.association.gating import gated_pairs, slots
from mctrack_ros.fusion.association.scored_pairs import JudgedPairs, judged_pairs
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.association.solvers.covering_graph import flags, shared_out
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.measurements.packed import measured
from mctrack_ros.fusion.motion.information import gathered
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import inverse, position_matrix

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


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
        cost = self.costs(table, batch, track, batch.single[detection])
        near = np.flatnonzero(cost < np.inf)
        track, detection, where = track[near], detection[near], where[near]
        pairs = Pairs(track, detection, slots(where, track), np.exp(-cost[near] / 2), where)
        self._pairs = pairs
        self._chosen = ASSOCIATORS[config.method]().probabilities(pairs)
        self._information = gathered(
            self._mean,
            self._seconds,
            pairs.image,
            pairs.track,
            pairs.detection,
            self._chosen,
            seen,
        )

    @staticmethod
    def costs(table: TrackTable, batch: Batch, track: Indices, row: Indices) -> Floats:
        """Return the squared Mahalanobis distances (k,) of pairs; infinite would be no pair."""
        seconds = batch.seconds[batch.image[row]]
        matrix = position_matrix(seconds)
        apart = batch.position[row] - np.einsum('kij,kj->ki', matrix, table.mean[track])
        spread = matrix @ table.covariance[track] @ matrix.swapaxes(-1, -2) + batch.noise[row]
        return np.asarray(np.einsum('ki,kij,kj->k', apart, inverse(spread), apart))

    def solve(self) -> Floats:
        """Return what the images tell of the tracks, (n, 13), of each one image at most."""
        return self._information

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
            (self._mean, self._covariance),
            np.zeros(len(row)),
            batch,
            pairs.track,
            row,
            pairs.slot,
            self._chosen,
            np.array(taken, np.bool_),
        )

    @property
    def gated(self) -> Indices:
        """Return the detections (k,) of all pairs."""
        return self._single[self._pairs.detection]

    @property
    def consumed(self) -> Indices:
        """Return the detections (k,) in the gate of tracks whose primary sensor is another."""
        return self._single[self._pairs.detection[~flags(self._pairs)]]
