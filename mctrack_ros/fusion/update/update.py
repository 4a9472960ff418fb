"""All images of a tick against the tracks: assignment, update, what else is learned."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled, inner
from mctrack_ros.fusion.association.joint import JointAssociation
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.admission import ROWS
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import Motion
from mctrack_ros.fusion.reid.appearance import collect
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.fusion.update.covering import CoveringAssociation
from mctrack_ros.fusion.update.hidden_members import keep_members
from mctrack_ros.interfaces import LARGEST_EXTENT

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Stamps = NDArray[np.int64]

MOST_AT_ONCE = 0.5
"""Share of a track's size that one detection is at most."""
EXTENT_NS = 8e9
"""Time constant of its size, ns."""
CLASS_S, MOST_CLASS_S = 1.0, 3.0
"""For so long one detection tells a class at most, and for so long a class leads at most, s."""
ASSOCIATIONS: dict[str, type[Any]] = {'covering_graph': CoveringAssociation}
"""By method, what associates the images of a tick; that of all others is `JointAssociation`."""


def match(
    table: TrackTable,
    batch: Batch,
    config: JointConfig,
    motion: Motion,
    recorder: DecisionRecorder | None = None,
) -> tuple[Indices, NDArray[np.bool_], Indices, Indices]:
    """
    Associate the images of a tick with the tracks and update these.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp; changed in place.
    batch : Batch
        The images.
    config : JointConfig
        Parameters.
    motion : Motion
        How tracks move.
    recorder : DecisionRecorder, optional
        Takes down why.

    Returns
    -------
    left : (k,) array
        The single detections that no track took, and that may start one.
    is_gated : (k,) bool array
        Which of these lie in the gate of a track, which took another.
    rows, columns : (n,) arrays
        The tracks and the detections that are each other's.

    """
    kind = ASSOCIATIONS.get(config.association.method, JointAssociation)
    association = kind(table, batch, config.association)
    reported = association.solve()
    if recorder is not None:
        recorder.pairs(association.judged(table, batch, config.association), table, batch)
    motion.update(table, reported)
    rows, columns = association.pairs()
    if batch.has_templates:
        collect(table, batch, rows, columns)
    note(table, batch, rows, columns)
    if batch.has_groups:
        free = np.ones((len(batch.seconds), len(table)), bool)
        free[batch.image[columns], rows] = False
        keep_members(table, batch, free, config, motion, recorder)
    left = _left(batch.single, len(batch.rows), columns, association.consumed)
    is_gated = np.zeros(len(batch.rows), np.bool_)
    is_gated[association.gated] = True
    return left, is_gated[left], rows, columns


@compiled(types.i8[::1](INTS_1D, types.i8, INTS_1D, INTS_1D))
def _left(single: Indices, count: int, columns: Indices, consumed: Indices) -> Indices:
    """Return the single ones of so many detections that are neither paired nor consumed."""
    taken = np.zeros(count, np.bool_)
    taken[columns] = True
    taken[consumed] = True
    return single[~taken[single]]


def note(table: TrackTable, batch: Batch, rows: Indices, columns: Indices) -> None:
    """Note in tracks (k,) what the detections (k,) tell beside place and colours."""
    _note(table.fixed, table.seen_by_ns, rows, columns, batch.rows)


@inner
def _vote(track: Any, kind: int, seconds: float) -> None:
    """Let a camera tell a class: the lead of another one shrinks, and then it is this one."""
    ahead = track['class_lead_s'] + (seconds if kind == track['class_id'] else -seconds)
    if ahead < 0.0 or track['class_id'] == 0:
        track['class_id'] = kind
    track['class_lead_s'] = min(abs(ahead), MOST_CLASS_S)


@compiled(
    types.void(
        TRACKS, types.Array(types.i8, 2, 'A'), INTS_1D, INTS_1D, ROWS,
    )
)  # fmt: skip
def _note(tracks: Any, seen_by_ns: Stamps, rows: Indices, columns: Indices, reported: Any) -> None:
    extent, reported_extent = tracks['extent'], reported['extent']
    for index in range(len(rows)):
        row, column = rows[index], columns[index]
        track, one = tracks[row], reported[column]
        own, stamp_ns = one['camera'], one['stamp_ns']
        since_ns = stamp_ns - seen_by_ns[row, own]
        kind = one['class_id']
        is_sure = kind == track['class_id'] and track['class_lead_s'] == MOST_CLASS_S
        if kind > 0 and not is_sure:
            _vote(track, kind, min(since_ns / 1e9, CLASS_S))
        share = min(since_ns / EXTENT_NS, MOST_AT_ONCE)
        for axis in range(2):
            size = reported_extent[column, axis]
            if 0.0 < size < LARGEST_EXTENT:
                known = extent[row, axis]
                extent[row, axis] = known + share * (size - known) if known > 0.0 else size
        track['seen_ns'] = max(track['seen_ns'], stamp_ns)
        track['kept_ns'] = track['seen_ns']
        seen_by_ns[row, own] = stamp_ns
        track['cameras'] |= np.uint32(1) << np.uint32(own)
