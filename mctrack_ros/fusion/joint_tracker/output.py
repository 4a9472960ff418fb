"""What fusion publishes: tracks, feedback, events, each in canonical order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled, inner
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.interfaces import (
    Events,
    Feedback,
    Tracks,
    TrackStatus,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


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


def _columns(
    tracks: NDArray[Any], is_published: NDArray[np.bool_], ended: NDArray[Any], stamp_ns: int
) -> tuple[NDArray[Any], ...]:
    """Return the columns of `Tracks`: what is published of tracks, and of those that ended."""
    rows = is_published.nonzero()[0]
    names = np.concatenate((tracks['track_id'][rows], ended['track_id']))
    place = np.empty(len(names), np.int64)
    place[names.argsort()] = np.arange(len(names))
    return _written(tracks, rows, ended, place, stamp_ns)


def status_of(is_confirmed: bool, cameras: int, group: int) -> int:
    """Return the `TrackStatus` of a living track, by the cameras that see it and its group."""
    if not is_confirmed:
        return TrackStatus.TENTATIVE.value
    if cameras:
        return TrackStatus.CONFIRMED.value
    return TrackStatus.GROUPED.value if group else TrackStatus.COASTING.value


_status = inner(status_of)


@compiled(
    types.Tuple([
        types.f4[:, ::1], types.f4[:, ::1], types.f4[:, :, ::1], types.f4[:, ::1],
        types.f4[::1], types.f4[::1], types.u4[::1], types.u4[::1], types.u4[::1],
        types.u1[::1], types.u1[::1], types.u1[::1], types.u1[::1],
    ])(TRACKS, INTS_1D, TRACKS, INTS_1D, types.i8)
)  # fmt: skip
def _written(
    tracks: Any, rows: Indices, ended: Any, place: Indices, stamp_ns: int
) -> tuple[NDArray[Any], ...]:
    """Write the columns: some rows (k,) of tracks, then those that ended, to places (k + m,)."""
    count = len(place)
    position, velocity = np.empty((count, 3), np.float32), np.empty((count, 2), np.float32)
    covariance, extent = np.empty((count, 4, 4), np.float32), np.empty((count, 2), np.float32)
    age, score = np.empty(count, np.float32), np.empty(count, np.float32)
    track_id, group = np.empty(count, np.uint32), np.empty(count, np.uint32)
    cameras, member_count = np.empty(count, np.uint32), np.empty(count, np.uint8)
    status, class_id = np.empty(count, np.uint8), np.empty(count, np.uint8)
    kit = np.empty(count, np.uint8)
    for index in range(count):
        to, is_over = place[index], index >= len(rows)
        own = ended[index - len(rows)] if is_over else tracks[rows[index]]
        mean, spread, size = own['mean'], own['covariance'], own['extent']
        for i in range(2):
            position[to, i], velocity[to, i], extent[to, i] = mean[i], mean[2 + i], size[i]
        position[to, 2] = 0.0
        for i in range(4):
            for j in range(4):
                covariance[to, i, j] = spread[i, j]
        age[to] = (stamp_ns - own['first_ns']) / 1e9
        score[to] = 1.0 / (1.0 + np.exp(-own['evidence']))
        track_id[to], group[to], cameras[to] = own['track_id'], own['group'], own['cameras']
        member_count[to], class_id[to], kit[to] = 1, own['class_id'], own['kit']
        status[to] = _status(own['confirmed'], own['cameras'], own['group'])
        if is_over:
            status[to] = TrackStatus.DELETED.value
    return (
        position, velocity, covariance, extent, age, score, track_id, group, cameras,
        member_count, status, class_id, kit,
    )  # fmt: skip


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
