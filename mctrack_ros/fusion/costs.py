"""What a pair of a track and a detection costs beside their distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import AssociationConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.appearance import squared_hellinger

Floats = NDArray[np.float64]


def prior_costs(table: TrackTable, looks: Looks, config: AssociationConfig) -> Floats:
    """
    Return the (k, n) costs of pairing the single detections of a tick with the tracks.

    Minus twice the logarithm of a likelihood ratio, "this target's" against "nobody's", but for
    the density of the position: what the camera believes, appearance, and how sure the track is.
    """
    cost = config.appearance_weight * _differences(table, looks, config)
    trust = np.where(looks.is_overlapped[looks.single], config.overlap_trust, 1.0)
    cost += config.identity_bonus * trust[:, None] * _disbelief(table, looks)
    cost += np.where(table.confirmed, 0.0, config.tentative_cost)
    cost += 2 * np.log(2 * np.pi * config.false_density)
    return cost


def _disbelief(table: TrackTable, looks: Looks) -> Floats:
    """Return -1 where the camera takes the pair for one target, 1 for two, 0 unknown."""
    global_id = looks.detections.track_id[looks.single, None]
    local_id = looks.detections.local_id[looks.single, None]
    told = global_id == table.track_id
    remembered = (local_id == table.local_id.T[looks.camera[looks.single]]) & (local_id > 0)
    believed = np.where(told.any(axis=1, keepdims=True), told, remembered)
    return np.where(believed, -1.0, believed.any(axis=1, keepdims=True).astype(np.float64))


def _differences(table: TrackTable, looks: Looks, config: AssociationConfig) -> Floats:
    """Return how much more than usual templates differ, 0 where one is not known."""
    theirs, ours = looks.detections.template[looks.single], table.template
    both: NDArray[np.bool_] = np.outer(theirs.any(axis=1), ours.any(axis=1))
    if not both.any():
        return np.zeros(both.shape)
    difference = squared_hellinger(theirs, ours)
    return np.where(both, difference - config.usual_difference, 0.0)
