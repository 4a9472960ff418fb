"""What a pair of a track and a detection costs beside their distance."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.likeness import likeness_costs
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import AssociationConfig
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Templates = NDArray[np.float32]
_TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)
_TABLE_TEMPLATES = types.Array(types.f4, 2, 'A', readonly=True)


def prior_costs(
    table: TrackTable, looks: Looks, track: Indices, detection: Indices, config: AssociationConfig
) -> Floats:
    """
    Return the (k,) costs of pairs of tracks and single detections of a tick.

    Minus twice the logarithm of a likelihood ratio, "this target's" against "nobody's", but for
    the density of the position: what the camera believes, appearance, and how sure the track is.
    """
    row = looks.single[detection]
    cost = config.appearance_weight * _differences(
        table.template, looks.detections.template, track, row, config.usual_difference
    )
    cost += likeness_costs(table, looks, track, row, config)
    trust = np.where(looks.is_overlapped[row], config.overlap_trust, 1.0)
    cost += config.identity_bonus * trust * _disbelief(table, looks, track, row)
    cost += np.where(table.confirmed[track], 0.0, config.tentative_cost)
    cost += 2 * np.log(2 * np.pi * config.false_density)
    return cost


def _disbelief(table: TrackTable, looks: Looks, track: Indices, row: Indices) -> Floats:
    """Return -1 where the camera takes the pair for one target, 1 for two, 0 unknown."""
    global_id, local_id = looks.detections.track_id[row], looks.detections.local_id[row]
    if not global_id.any() and not local_id.any():
        return np.zeros(len(row))
    is_told = np.isin(global_id, table.track_id)
    remembered = (local_id == table.local_id[track, looks.camera[row]]) & (local_id > 0)
    believed = np.where(is_told, global_id == table.track_id[track], remembered)
    is_known = np.zeros(len(looks.picture), bool)
    is_known[row[believed | is_told]] = True
    return np.where(believed, -1.0, is_known[row].astype(np.float64))


@compiled(types.f8[::1](_TABLE_TEMPLATES, _TEMPLATES, INTS_1D, INTS_1D, types.f8))
def _differences(
    ours: Templates, theirs: Templates, track: Indices, row: Indices, usual: float
) -> Floats:
    """Return how much more than usual templates differ, (k,), 0 where one is not known."""
    difference = np.zeros(len(track))
    for pair in range(len(track)):
        one, other = ours[track[pair]], theirs[row[pair]]
        if one.any() and other.any():
            alike = 0.0
            for bin in range(len(one)):
                alike += np.sqrt(max(one[bin], 0.0) * max(other[bin], 0.0))
            difference[pair] = min(max(1.0 - alike, 0.0), 1.0) - usual
    return difference
