"""The joint association of all images of a tick with the tracks."""

from __future__ import annotations

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
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.association.gating import distance, gated_pairs, seen_at
from mctrack_ros.fusion.association.likelihood import prior_costs
from mctrack_ros.fusion.association.scored_pairs import JudgedPairs, judged_pairs
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.measurements.packed import XX, XY, YY, X, Y, measured
from mctrack_ros.fusion.motion.information import gathered, joined, updated, without
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SWEEPS = 3
"""Of the association: by prediction alone, then corrected at most this often less one."""
SETTLED = 0.01
"""It is settled when no probability changes by more."""
LEAST = 0.01
"""The best pair of a slot and of a detection is theirs if it is as probable as that."""


class JointAssociation:
    """
    Associates every image of a tick in the light of all others.

    Images are associated first with the predicted tracks, then again with what prediction and
    all *other* images say of them, until nothing changes: iterated conditional modes of the
    joint assignment (Besag 1986), where the associator is a hard one. One image's mistake is so
    corrected by the others instead of dragging them along, and the order of the cameras does not
    matter. A pair counts for as much as it is probable: what a slot's pairs measure is joined,
    each with its information times its probability.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp.
    batch : Batch
        The images.
    config : JointAssociationConfig
        Parameters.

    Attributes
    ----------
    consumed : (0,) int array
        No detections start no track but those that are paired.
    gated : (k,) int array
        The detections of all pairs in the gate, after `solve`.

    """

    consumed: Indices = np.empty(0, np.int64)

    def __init__(self, table: TrackTable, batch: Batch, config: JointAssociationConfig) -> None:
        single = batch.single
        self._single, self._gate, self._seconds = single, config.gate, batch.seconds
        self._associator = ASSOCIATORS[config.method]()
        self._seen = measured(batch.position, batch.noise, single)
        self._mean, self._covariance = table.mean, table.covariance
        self._track, self._detection, self._image, self._slot = gated_pairs(
            self._mean,
            self._covariance,
            self._seconds,
            self._seen,
            batch.image[single],
            config.gate,
        )
        self._prior = prior_costs(table, batch, self._track, self._detection, config)
        self._probability = np.zeros(len(self._track))

    def solve(self) -> Floats:
        """Return what the images tell of the tracks, (n, 13), see `gathered`."""
        for _ in range(SWEEPS):
            self._judged_by = self._probability
            reported, near, pairs = self._near()
            self.gated = self._single[pairs.detection]
            chosen = self._associator.probabilities(pairs)
            self._probability, is_settled = _settled(self._judged_by, near, chosen)
            if is_settled:
                return reported
        return self._information(self._probability)

    def pairs(self) -> tuple[Indices, Indices]:
        """
        Return the tracks (k,) and the detections (k,) that are each other's best in an image.

        Sorted by image, then track.
        """
        track, row = _best(
            self._slot, self._track, self._detection, self._single, self._probability, LEAST
        )
        return track, row

    def judged(
        self, table: TrackTable, batch: Batch, config: JointAssociationConfig
    ) -> JudgedPairs:
        """Return all pairs as they were judged last, after `solve`: for whoever asks why."""
        reported = self._information(self._judged_by)
        pairs = judged_pairs(
            updated(self._mean, self._covariance, reported),
            self._judged_by,
            batch,
            self._track,
            self._single[self._detection],
            self._slot,
            self._probability,
            _mutual(self._slot, self._detection, self._probability, LEAST),
        )
        return pairs.weighed(table, batch, config)

    def _near(self) -> tuple[Floats, Indices, Pairs]:
        """Return what the pairs tell by now, (n, 13), and which (k,) are near in its light."""
        reported, (near, track, detection, slot, image), likelihood = _likelihoods(
            self._mean,
            self._covariance,
            self._seconds,
            self._image,
            self._track,
            self._detection,
            self._probability,
            self._seen,
            self._prior,
            self._gate,
        )
        return reported, near, Pairs(track, detection, slot, likelihood, image)

    def _information(self, probability: Floats) -> Floats:
        return gathered(
            self._mean,
            self._seconds,
            self._image,
            self._track,
            self._detection,
            probability,
            self._seen,
        )


@compiled(types.Tuple([types.f8[::1], types.b1])(FLOATS_1D, INTS_1D, FLOATS_1D))
def _settled(before: Floats, near: Indices, chosen: Floats) -> tuple[Floats, bool]:
    """Return probabilities (k,), 0 but for the near ones, and whether none has changed much."""
    probability, is_settled = np.zeros(len(before)), True
    for index in range(len(near)):
        probability[near[index]] = chosen[index]
    for pair in range(len(before)):
        is_settled &= np.abs(probability[pair] - before[pair]) < SETTLED
    return probability, is_settled


@compiled(
    types.Tuple([types.f8[:, ::1], types.i8[:, :], types.f8[::1]])(
        COLUMN_2D, COLUMN_3D, FLOATS_1D, INTS_1D, INTS_1D, INTS_1D, FLOATS_1D, FLOATS_2D,
        FLOATS_1D, types.f8,
    )
)  # fmt: skip
def _likelihoods(
    mean: Floats, covariance: Floats, seconds: Floats, image: Indices, track: Indices,
    detection: Indices, probability: Floats, seen: Floats, prior: Floats, gate: float,
) -> tuple[Floats, Indices, Floats]:  # fmt: skip
    """
    Judge the pairs by what prediction and the other images say of the tracks.

    Returns
    -------
    reported : (n, 13) array
        What the pairs tell of the tracks, see `gathered`.
    near : (5, m) int64 array
        Those of the pairs that pass the gate; their track, detection, slot and image, see
        `Pairs`.
    likelihood : (m,) array
        Of these.

    """
    reported = gathered(mean, seconds, image, track, detection, probability, seen)
    state, spread = updated(mean, covariance, reported)
    count = len(track)
    near, cost = np.empty((5, count), np.int64), np.empty(count)
    found, slots, first = 0, 0, 0
    while first < count:
        last = first + 1
        while last < count and track[last] == track[first] and image[last] == image[first]:
            last += 1
        x, y, xx, xy, yy = seen_at(state, spread, track[first], seconds[image[first]])
        has_information, w_xx, w_xy, w_yy, pull_x, pull_y = joined(
            first, last, detection, probability, seen
        )
        if has_information:
            x, y, xx, xy, yy = without(x, y, xx, xy, yy, w_xx, w_xy, w_yy, pull_x, pull_y)
        before = found
        for pair in range(first, last):
            row = detection[pair]
            squared, determinant = distance(
                seen[row, X] - x,
                seen[row, Y] - y,
                xx + seen[row, XX],
                xy + seen[row, XY],
                yy + seen[row, YY],
            )
            if squared < gate:
                near[0, found], near[1, found], near[2, found] = pair, track[pair], row
                near[3, found], near[4, found] = slots, image[pair]
                cost[found], found = squared + np.log(determinant) + prior[pair], found + 1
        slots += found > before
        first = last
    return reported, near[:, :found], np.exp(-cost[:found] / 2)


@compiled(types.b1[::1](INTS_1D, INTS_1D, FLOATS_1D, types.f8))
def _mutual(
    slot: Indices, detection: Indices, probability: Floats, least: float
) -> NDArray[np.bool_]:
    """Return which pairs (k,) are both their slot's and their detection's best."""
    count = len(slot)
    of_slot = np.zeros(slot[-1] + 1 if count else 0)
    of_detection = np.zeros(detection.max() + 1 if count else 0)
    for pair in range(count):
        own = probability[pair]
        of_slot[slot[pair]] = max(of_slot[slot[pair]], own)
        of_detection[detection[pair]] = max(of_detection[detection[pair]], own)
    best = np.zeros(count, np.bool_)
    for pair in range(count):
        own = probability[pair]
        wins = own >= of_slot[slot[pair]] and own >= of_detection[detection[pair]]
        if wins and own >= least:
            best[pair] = True
            of_slot[slot[pair]] = of_detection[detection[pair]] = np.inf
    return best


@compiled(types.i8[:, ::1](INTS_1D, INTS_1D, INTS_1D, INTS_1D, FLOATS_1D, types.f8))
def _best(
    slot: Indices, track: Indices, detection: Indices, single: Indices, probability: Floats,
    least: float,
) -> Indices:  # fmt: skip
    """Return the tracks and the rows of the single detections, (2, m), of `_mutual` pairs."""
    pairs = np.flatnonzero(_mutual(slot, detection, probability, least))
    best = np.empty((2, len(pairs)), np.int64)
    for index, pair in enumerate(pairs):
        best[0, index], best[1, index] = track[pair], single[detection[pair]]
    return best
