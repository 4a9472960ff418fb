"""What a pair of a track and a detection costs beside their distance."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, INTS_1D, compiled
from mctrack_ros.fusion.likeness import likeness_costs
from mctrack_ros.fusion.looks import Looks, described
from mctrack_ros.fusion.parameters import AssociationConfig
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Templates = NDArray[np.float32]
Ids = NDArray[np.uint32]
Mask = NDArray[np.bool_]
_TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)
_TABLE_TEMPLATES = types.Array(types.f4, 2, 'A', readonly=True)
_IDS = types.Array(types.u4, 1, 'C', readonly=True)
_TABLE_IDS = types.Array(types.u4, 1, 'A', readonly=True)
_MEMORY = types.Array(types.u4, 2, 'A', readonly=True)


def prior_costs(
    table: TrackTable, looks: Looks, track: Indices, detection: Indices, config: AssociationConfig
) -> Floats:
    """
    Return the (k,) costs of pairs of tracks and single detections of a tick.

    Minus twice the logarithm of a likelihood ratio, "this target's" against "nobody's", but for
    the density of the position: what the camera believes, appearance, and how sure the track is.
    """
    parts = cost_parts(table, looks, track, looks.single[detection], config)
    cost = parts['appearance']
    for name in ('likeness', 'belief', 'doubt'):
        cost += parts[name]
    cost += clutter_cost(config)
    return cost


def cost_parts(
    table: TrackTable, looks: Looks, track: Indices, row: Indices, config: AssociationConfig
) -> dict[str, Floats]:
    """Return the (k,) costs of tracks and detections, (k,) rows each, by what speaks."""
    told = looks.detections
    is_known = described(table.template)[track] & looks.is_described[row]
    difference = differences(
        table.template, told.template, is_known, track, row, config.usual_difference
    )
    disbelief = _disbelief(
        told.track_id, told.local_id, looks.camera, table.track_id, table.local_id, track, row
    )
    trust = np.where(looks.is_overlapped[row], config.overlap_trust, 1.0)
    return {
        'appearance': config.appearance_weight * difference,
        'likeness': likeness_costs(table, looks, track, row, is_known, config),
        'belief': config.identity_bonus * trust * disbelief,
        'doubt': np.where(table.confirmed[track], 0.0, config.tentative_cost),
    }


def clutter_cost(config: AssociationConfig) -> float:
    """Return what false detections cost a pair, per unit of area of its uncertainty."""
    return float(2 * np.log(2 * np.pi * config.false_density))


@compiled(types.f8[::1](_IDS, _IDS, INTS_1D, _TABLE_IDS, _MEMORY, INTS_1D, INTS_1D))
def _disbelief(
    global_id: Ids,
    local_id: Ids,
    camera: Indices,
    track_id: Ids,
    remembered: Ids,
    track: Indices,
    row: Indices,
) -> Floats:
    """
    Return -1 where the camera takes the pair (k,) for one target, 1 for two, 0 unknown.

    A global id that the camera was told goes before what it calls the target itself.
    """
    ids = np.sort(track_id)
    is_told, is_known = np.zeros(len(global_id), np.bool_), np.zeros(len(global_id), np.bool_)
    for one in range(len(global_id)):
        at = np.searchsorted(ids, global_id[one]) if global_id[one] else len(ids)
        is_told[one] = at < len(ids) and ids[at] == global_id[one]
    belief = np.zeros(len(track))
    for pair in range(len(track)):
        own, one = track[pair], row[pair]
        if is_told[one]:
            believed = global_id[one] == track_id[own]
        else:
            believed = local_id[one] > 0 and local_id[one] == remembered[own, camera[one]]
        if believed:
            belief[pair] = -1.0
        is_known[one] |= believed or is_told[one]
    for pair in range(len(track)):
        if belief[pair] == 0.0 and is_known[row[pair]]:
            belief[pair] = 1.0
    return belief


@compiled(types.f8[::1](_TABLE_TEMPLATES, _TEMPLATES, BOOLS_1D, INTS_1D, INTS_1D, types.f8))
def differences(
    ours: Templates, theirs: Templates, is_known: Mask, track: Indices, row: Indices, usual: float
) -> Floats:
    """Return how much more than usual templates differ, (k,), 0 where one is not known."""
    difference = np.zeros(len(track))
    for pair in np.flatnonzero(is_known):
        alike = 0.0
        for bin in range(ours.shape[1]):
            one, other = ours[track[pair], bin], theirs[row[pair], bin]
            alike += np.sqrt(max(one, 0.0) * max(other, 0.0))
        difference[pair] = min(max(1.0 - alike, 0.0), 1.0) - usual
    return difference
