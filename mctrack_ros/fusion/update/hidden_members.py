"""Members of a group whom a merged detection hides: kept alive, and taken along."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    FLOATS_1D,
    FLOATS_2D,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.fusion.association.gating import distances
from mctrack_ros.fusion.config import LOOK_S
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import Motion
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.tracking.kalman import updated

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Stamps = NDArray[np.int64]
Mask = NDArray[np.bool_]

VELOCITY = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])

HIDDEN_S = 1.0
"""A track is kept for so long by its group alone, if others of it are seen, s: as one coasts."""

GROUP_INFLATION = 100.0
"""How much less a merged detection says about one of its members, image after image: factor
of its covariance. He keeps his place in the group, and is not drawn to its middle."""

COMPANY_DENSITY = 0.5
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

    Only who is expected where the group is, by its own covariance. Where others of it are
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
            _keep(
                table.fixed,
                table.hidden_ns[:, batch.camera[groups[row]]],
                members,
                whole,
                batch.position[groups[row]],
                noise[row] * GROUP_INFLATION,
                batch.seconds[image[row]],
                batch.stamp_ns[groups[row]],
                LOOK_S,
            )
            motion.follow(table, members)


@inner
def _corrected(
    mean: Floats, covariance: Floats, row: int, innovation: Floats, noise: Floats, matrix: Floats
) -> None:
    """Update one track in place."""
    own = slice(row, row + 1)
    mean[own], covariance[own] = updated(
        mean[own].copy(),
        covariance[own].copy(),
        innovation.reshape(1, 2),
        np.ascontiguousarray(noise).reshape(1, 2, 2),
        np.ascontiguousarray(matrix).reshape(1, 2, 4),
    )


@compiled(
    types.void(
        TRACKS, types.Array(types.i8, 1, 'A'), INTS_1D, BOOLS_1D, FLOATS_1D, FLOATS_2D,
        types.f8, types.i8, types.f8,
    )
)  # fmt: skip
def _keep(
    tracks: Any, hidden_ns: Stamps, members: Indices, whole: Mask, position: Floats,
    noise: Floats, seconds: float, stamp_ns: int, longest_s: float,
) -> None:  # fmt: skip
    """
    Update the hidden members (k,) of a merged detection; `whole` (n,) is all of the group.

    Those whom no camera sees go on for a while as others of their group do.
    """
    mean, covariance, cameras = tracks['mean'], tracks['covariance'], tracks['cameras']
    since_s = np.empty(len(members))
    for index in range(len(members)):
        row = members[index]
        since_s[index] = min((stamp_ns - hidden_ns[row]) / 1e9, longest_s)
        place = mean[row, :2] + seconds * mean[row, 2:]
        matrix = np.eye(4)[:2]
        matrix[0, 2] = matrix[1, 3] = seconds
        _corrected(mean, covariance, row, position - place, noise, matrix)
        tracks[row]['kept_ns'] = max(tracks[row]['kept_ns'], stamp_ns)
        hidden_ns[row] = stamp_ns
    velocity, shown = np.zeros(2), 0
    for row in range(len(whole)):
        if whole[row] and cameras[row] > 0:
            velocity += mean[row, 2:]
            shown += 1
    for index in range(len(members)):
        row = members[index]
        if shown and cameras[row] == 0:
            spread = COMPANY_DENSITY / since_s[index] * np.eye(2)
            _corrected(mean, covariance, row, velocity / shown - mean[row, 2:], spread, VELOCITY)
    everybody = np.flatnonzero(whole)
    if len(everybody) > 1:
        first = tracks['track_id'][everybody].min()
        for row in members:
            if cameras[row] == 0:
                tracks[row]['group'], tracks[row]['group_ns'] = first, stamp_ns
