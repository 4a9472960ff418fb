"""Members of a group whom a merged detection hides: kept alive, and taken along."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.gating import distances
from mctrack_ros.fusion.config import CORRELATED_S
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import Motion
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import position_matrix, update

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

VELOCITY = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])

HIDDEN_S = 1.0
"""A track is kept for so long by its group alone, if others of it are seen, s: as one coasts."""

GROUP_INFLATION = 100.0
"""How much less a merged detection says about one of its members, image after image: factor
of its covariance. He keeps his place in the group, and is not drawn to its middle."""

GROUP_VELOCITY_DENSITY = 0.5
"""How loosely a hidden member moves with those who are seen: power spectral density of what his
velocity differs from theirs by, m²/s."""


def keep_members(
    table: TrackTable,
    batch: Batch,
    free: Mask,
    config: JointConfig,
    motion: Motion,
    recorder: DecisionRecorder | None = None,
) -> None:
    """
    Keep alive what merged detections hide of the tracks that are free, (images, n).

    Only who is expected where the group is, by its covariance as told. Where others of it are
    seen, only for a while: it may be that nobody is behind them.
    """
    groups, detections = batch.groups, batch.detections
    image, noise = batch.image[groups], batch.noise[groups]
    named = (table.track_id[:, None] == detections.members[groups, None]).any(axis=2)
    taken = (named & ~free[image]).sum(axis=1)
    hidden_s = (batch.stamp_ns[groups, None] - table.seen_ns) / 1e9
    hoped = (hidden_s <= HIDDEN_S) | (taken == 0)[:, None]
    squared = distances(
        table.mean, table.covariance, batch.seconds[image], batch.position[groups], noise
    )
    hidden = free[image] & table.confirmed & hoped & (squared < config.association.gate)
    for row in np.flatnonzero(hidden.any(axis=1)).tolist():
        candidates = np.flatnonzero(hidden[row] & free[image[row]])
        order = np.lexsort((squared[row, candidates], ~named[row, candidates]))
        whole = named[row] & ~free[image[row]]
        count = int(detections.member_count[groups[row]]) or len(candidates)
        members = np.sort(candidates[order[: max(count - int(whole.sum()), 0)]])
        if len(members):
            free[image[row], members] = False
            whole[members] = True
            if recorder is not None:
                recorder.hidden(members, int(groups[row]), squared[row, members], table, batch)
            spread = noise[row] * GROUP_INFLATION
            _keep(table, batch, int(groups[row]), members, whole, spread)
            motion.follow(table, members)


def _keep(
    table: TrackTable, batch: Batch, group: int, members: Indices, whole: Mask, noise: Floats
) -> None:
    """
    Update the hidden members (k,) of a merged detection; `whole` (n,) is all of the group.

    Those whom no camera sees go on for a while as others of their group do.
    """
    seconds, stamp_ns = batch.seconds[batch.image[group]], batch.stamp_ns[group]
    hidden_ns = table.hidden_ns[:, batch.camera[group]]
    since_s = np.minimum((stamp_ns - hidden_ns[members]) / 1e9, CORRELATED_S)
    place = table.mean[members, :2] + seconds * table.mean[members, 2:]
    _correct(table, members, batch.position[group] - place, noise, position_matrix(seconds))
    table.kept_ns[members] = np.maximum(table.kept_ns[members], stamp_ns)
    hidden_ns[members] = stamp_ns
    seen = whole & (table.cameras > 0)
    unseen = table.cameras[members] == 0
    alone = members[unseen]
    if not len(alone):
        return
    if seen.any():
        velocity = table.mean[seen, 2:].sum(axis=0) / seen.sum()
        spread = (GROUP_VELOCITY_DENSITY / since_s[unseen])[:, None, None] * np.eye(2)
        _correct(table, alone, velocity - table.mean[alone, 2:], spread, VELOCITY)
    if whole.sum() > 1:
        table.group[alone], table.group_ns[alone] = table.track_id[whole].min(), stamp_ns


def _correct(
    table: TrackTable, rows: Indices, innovation: Floats, noise: Floats, matrix: Floats
) -> None:
    """Update some tracks, one covariance for all or one each."""
    each = np.broadcast_to(noise, (len(rows), 2, 2))
    state = table.mean[rows], table.covariance[rows]
    table.mean[rows], table.covariance[rows] = update(*state, innovation, each, matrix)
