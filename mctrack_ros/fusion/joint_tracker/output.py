"""What fusion publishes: tracks, feedback, events, each in canonical order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    COLUMN_FLAGS,
    COLUMN_IDS,
    compiled,
    inner,
)
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.interfaces import (
    Events,
    Feedback,
    Tracks,
    TrackStatus,
)

Floats = NDArray[np.float64]
Told = NDArray[np.float32]
Indices = NDArray[np.intp]
Ids = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

STATUS = list(Tracks.COLUMNS).index('status')
"""Which column of `Tracks` that is."""


@dataclass(frozen=True, eq=False, slots=True)
class Gates:
    """
    What became of a tick's detections, counted by camera in the site's order.

    Attributes
    ----------
    detections, in_no_gate, taken_by_others : (cameras,) int arrays
        All; those that lie in the gate of no track; and those whose tracks took others.

    """

    detections: Indices
    in_no_gate: Indices
    taken_by_others: Indices


def gates_of(camera: Indices, left: Indices, is_gated: NDArray[np.bool_], cameras: int) -> Gates:
    """
    Count what became of detections.

    Parameters
    ----------
    camera : (m,) int array
        Which of so many cameras each is of.
    left : (k,) int array
        Those that no track took.
    is_gated : (k,) bool array
        Which of these lie in the gate of a track.

    """
    rows = camera, camera[left[~is_gated]], camera[left[is_gated]]
    return Gates(*(np.bincount(each, minlength=cameras) for each in rows))


@dataclass(frozen=True, eq=False, slots=True)
class FusionOutput:
    """
    What one tick yields, all stamped with it.

    Attributes
    ----------
    tracks : Tracks
        Published tracks, and those that ended, sorted by id.
    events : Events
        What happened, sorted by code and track.
    left_out : mapping of str to str
        Cameras whose masks the tick did without, and why.
    gates : Gates, optional
        What became of the detections, where they are associated.

    """

    tracks: Tracks
    events: Events
    left_out: Mapping[str, str] = field(default_factory=dict)
    gates: Gates | None = None


def tracks_of(
    table: TrackTable, is_published: NDArray[np.bool_], ended: TrackTable, stamp_ns: int
) -> Tracks:
    """Return the published tracks and, once, those that ended, by id."""
    return Tracks.adopt(stamp_ns, _columns(table.fixed, is_published, ended.fixed, stamp_ns))


@inner
def _status(is_confirmed: bool, cameras: int, group: int) -> int:
    if not is_confirmed:
        return TrackStatus.TENTATIVE.value
    if cameras:
        return TrackStatus.CONFIRMED.value
    return TrackStatus.GROUPED.value if group else TrackStatus.COASTING.value


@inner
def _places(rows: Indices, track_id: Ids, ended_id: Ids) -> Indices:
    """Return the places by id of some rows of tracks (k,), and of those that ended."""
    names = np.concatenate((track_id[rows], ended_id))
    place = np.empty(len(names), np.int64)
    place[np.argsort(names)] = np.arange(len(names))
    return place


@inner
def _write(
    tracks: Any, rows: Indices, place: Indices, stamp_ns: int, columns: tuple[Any, ...]
) -> None:
    """Write what is published of rows of tracks (k,) into columns of `Tracks`, to places (k,)."""
    (
        to_position, to_velocity, to_covariance, to_extent, to_age, to_score, to_track_id,
        to_group, to_cameras, to_member_count, to_status, to_class_id, to_kit,
    ) = columns  # fmt: skip
    mean, covariance, extent = tracks['mean'], tracks['covariance'], tracks['extent']
    for row, to in zip(rows, place):
        own = tracks[row]
        for i in range(2):
            to_position[to, i], to_velocity[to, i] = mean[row, i], mean[row, 2 + i]
            to_extent[to, i] = extent[row, i]
        to_position[to, 2] = 0.0
        for i in range(4):
            for j in range(4):
                to_covariance[to, i, j] = covariance[row, i, j]
        to_age[to] = (stamp_ns - own['first_ns']) / 1e9
        to_score[to] = 1.0 / (1.0 + np.exp(-own['evidence']))
        to_track_id[to], to_group[to] = own['track_id'], own['group']
        to_cameras[to], to_member_count[to] = own['cameras'], 1
        to_status[to] = _status(own['confirmed'], own['cameras'], own['group'])
        to_class_id[to], to_kit[to] = own['class_id'], own['kit']


@compiled(
    types.Tuple([
        types.f4[:, ::1], types.f4[:, ::1], types.f4[:, :, ::1], types.f4[:, ::1],
        types.f4[::1], types.f4[::1], types.u4[::1], types.u4[::1], types.u4[::1],
        types.u1[::1], types.u1[::1], types.u1[::1], types.u1[::1],
    ])(TRACKS, BOOLS_1D, TRACKS, types.i8)
)  # fmt: skip
def _columns(
    tracks: Any, is_published: NDArray[np.bool_], ended: Any, stamp_ns: int
) -> tuple[NDArray[Any], ...]:
    """Return the columns of `Tracks`: what is published of tracks, and of those that ended."""
    rows = np.flatnonzero(is_published)
    count = len(rows) + len(ended)
    columns = (
        np.empty((count, 3), np.float32), np.empty((count, 2), np.float32),
        np.empty((count, 4, 4), np.float32), np.empty((count, 2), np.float32),
        np.empty(count, np.float32), np.empty(count, np.float32),
        np.empty(count, np.uint32), np.empty(count, np.uint32), np.empty(count, np.uint32),
        np.empty(count, np.uint8), np.empty(count, np.uint8), np.empty(count, np.uint8),
        np.empty(count, np.uint8),
    )  # fmt: skip
    place = _places(rows, tracks['track_id'], ended['track_id'])
    _write(tracks, rows, place, stamp_ns, columns)
    over, to_status = place[len(rows) :], columns[STATUS]
    _write(ended, np.arange(len(ended)), over, stamp_ns, columns)
    for to in over:
        to_status[to] = TrackStatus.DELETED.value
    return columns


def status_of(table: TrackTable) -> NDArray[np.uint8]:
    """Return the `TrackStatus` of tracks at a tick."""
    return _status_of(table.confirmed, table.cameras, table.group)


@compiled(types.u1[::1](COLUMN_FLAGS, COLUMN_IDS, COLUMN_IDS))
def _status_of(confirmed: NDArray[np.bool_], cameras: Ids, group: Ids) -> Bytes:
    status = np.empty(len(confirmed), np.uint8)
    for row in range(len(confirmed)):
        status[row] = _status(confirmed[row], cameras[row], group[row])
    return status


def feedback_of(table: TrackTable, stamp_ns: int) -> Feedback:
    """Return the feedback on tracks."""
    return Feedback.build(
        stamp_ns,
        position=ground_points(table),
        velocity=table.mean[:, 2:],
        covariance=table.covariance,
        extent=table.extent,
        template=table.template,
        track_id=table.track_id,
        previous_id=table.previous_id,
    )


def ground_points(table: TrackTable) -> NDArray[np.float64]:
    """Return the (n, 3) positions of tracks, on the ground, m."""
    points = np.zeros((len(table), 3))
    points[:, :2] = table.mean[:, :2]
    return points
