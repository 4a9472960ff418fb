"""The pairs of a tick as they were judged last: for whoever asks why."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.association.likelihood import cost_parts
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import inverse, position_matrix, symmetric

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class JudgedPairs:
    """
    Pairs of tracks and detections that were tried, sorted by image, then track.

    Attributes
    ----------
    track, row : (k,) int64 arrays
        Rows of the table of tracks, and of the detections of all images.
    place : (k, 2) array
        Where the image was to show the track, m.
    spread : (k, 2, 2) array
        Covariance of that, m².
    squared : (k,) array
        Squared Mahalanobis distance.
    probability : (k,) array
        With which the pair was used.
    taken : (k,) bool array
        Whether the two are each other's.
    costs : dict of str to (k,) array
        What speaks beside the distance, by the names of `Candidates`; empty where nothing does.

    """

    track: Indices
    row: Indices
    place: Floats
    spread: Floats
    squared: Floats
    probability: Floats
    taken: NDArray[np.bool_]
    costs: dict[str, Floats] = field(default_factory=dict)

    def weighed(
        self, table: TrackTable, batch: Batch, config: JointAssociationConfig
    ) -> JudgedPairs:
        """Return the same pairs with what they cost as likelihood ratios, see `prior_costs`."""
        determinant = np.linalg.det(self.spread + batch.noise[self.row])
        density = np.log(np.maximum(determinant, np.finfo(np.float64).tiny))
        costs = cost_parts(table, batch, self.track, self.row, config)
        costs['clutter'] += density
        return replace(self, costs=costs)


def judged_pairs(
    state: tuple[Floats, Floats],
    before: Floats,
    batch: Batch,
    track: Indices,
    row: Indices,
    slot: Indices,
    probability: Floats,
    taken: NDArray[np.bool_],
) -> JudgedPairs:
    """
    Work out again what the last sweep of an association judged its pairs by.

    Each image expects a track where prediction and all *other* images say that it is: what
    its own pairs measured is taken out of the state, in the information filter's form.

    Parameters
    ----------
    state : pair of (n, 4) and (n, 4, 4) arrays
        Means and covariances of the tracks that the sweep was given.
    before : (k,) array
        Probabilities of the pairs that those states are made of.
    batch : Batch
        The images.
    track, row, slot : (k,) int64 arrays
        Of the pairs, as in `JudgedPairs`; a slot is a track in an image.
    probability : (k,) array
        Of the pairs, that came out.
    taken : (k,) bool array
        As in `JudgedPairs`.

    """
    mean, covariance = state
    position, noise = batch.position[row], batch.noise[row]
    matrix = position_matrix(batch.seconds[batch.image[row]])
    place = np.einsum('kij,kj->ki', matrix, mean[track])
    spread = matrix @ covariance[track] @ matrix.swapaxes(-1, -2)
    weight, pull = _information(before, position, noise, slot)
    own = weight.any(axis=(1, 2))
    spread[own] = symmetric(inverse(inverse(spread[own]) - weight[own]))
    gap = np.einsum('kij,kj->ki', weight, place) - pull
    place = place + np.einsum('kij,kj->ki', spread, gap)
    apart = position - place
    squared = np.einsum('ki,kij,kj->k', apart, inverse(spread + noise), apart)
    return JudgedPairs(track, row, place, spread, squared, probability, taken)


def _information(
    probability: Floats, position: Floats, noise: Floats, slot: Indices
) -> tuple[Floats, Floats]:
    """Return what all pairs of each pair's slot measured, (k, 2, 2), and its sum, (k, 2)."""
    measured = probability[:, None, None] * inverse(noise)
    slots = int(slot.max(initial=-1)) + 1
    weight, pull = np.zeros((slots, 2, 2)), np.zeros((slots, 2))
    np.add.at(weight, slot, measured)
    np.add.at(pull, slot, np.einsum('kij,kj->ki', measured, position))
    return weight[slot], pull[slot]
