"""What fusion publishes: tracks, feedback, events, each in canonical order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.special import expit

from mctrack_ros.compiled import (
    BOOLS_1D,
    COLUMN_1D,
    COLUMN_2D,
    COLUMN_3D,
    COLUMN_BYTES,
    COLUMN_FLAGS,
    COLUMN_IDS,
    COLUMN_SINGLES_2D,
    COLUMN_STAMPS,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import (
    MEMBERS,
    EventCode,
    Events,
    Feedback,
    FeedbackFlag,
    Tracks,
    TrackStatus,
)

Floats = NDArray[np.float64]
Told = NDArray[np.float32]
Indices = NDArray[np.intp]
Ids = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

SEEN_MEMORY_NS = 500_000_000
"""A camera counts as seeing a target for so long after it did, ns."""


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

    """

    tracks: Tracks
    events: Events


def tracks_of(
    table: TrackTable, is_published: NDArray[np.bool_], ended: TrackTable, stamp_ns: int
) -> Tracks:
    """Return the published tracks and, once, those that ended, by id."""
    rows, place = _places(is_published, table.track_id, ended.track_id)
    columns = Tracks.unset(len(place))
    _tell(table, rows, place, columns, stamp_ns)
    if len(ended):
        over = place[len(rows) :]
        _tell(ended, np.arange(len(ended)), over, columns, stamp_ns)
        columns['status'][over] = TrackStatus.DELETED
    return Tracks.adopt(stamp_ns, columns)


@compiled(types.Tuple([types.i8[::1], types.i8[::1]])(BOOLS_1D, COLUMN_IDS, COLUMN_IDS))
def _places(
    is_published: NDArray[np.bool_], track_id: Ids, ended_id: Ids
) -> tuple[Indices, Indices]:
    """Return the rows (k,) that are published, and the places of these and of the ended by id."""
    rows = np.flatnonzero(is_published)
    names = np.concatenate((track_id[rows], ended_id))
    place = np.empty(len(names), np.int64)
    place[np.argsort(names)] = np.arange(len(names))
    return rows, place


def _tell(
    table: TrackTable, rows: Indices, place: Indices, columns: dict[str, Any], stamp_ns: int
) -> None:
    """Write what is published of tracks (k,) into columns of `Tracks`, to places (k, at least)."""
    _write(
        rows, place, stamp_ns,
        table.mean, table.covariance, table.extent, table.first_ns, table.evidence,
        table.confirmed, table.track_id, table.group, table.cameras, table.class_id, table.kit,
        *columns.values(),
    )  # fmt: skip


@inner
def _status(is_confirmed: bool, cameras: int, group: int) -> int:
    if not is_confirmed:
        return TrackStatus.TENTATIVE.value
    if cameras:
        return TrackStatus.CONFIRMED.value
    return TrackStatus.GROUPED.value if group else TrackStatus.COASTING.value


@compiled(
    types.void(
        INTS_1D, INTS_1D, types.i8,
        COLUMN_2D, COLUMN_3D, COLUMN_SINGLES_2D, COLUMN_STAMPS, COLUMN_1D, COLUMN_FLAGS,
        COLUMN_IDS, COLUMN_IDS, COLUMN_IDS, COLUMN_BYTES, COLUMN_BYTES,
        types.f4[:, ::1], types.f4[:, ::1], types.f4[:, :, ::1], types.f4[:, ::1],
        types.f4[::1], types.f4[::1], types.u4[::1], types.u4[::1], types.u4[::1],
        types.u1[::1], types.u1[::1], types.u1[::1], types.u1[::1],
    )
)  # fmt: skip
def _write(
    rows: Indices, place: Indices, stamp_ns: int,
    mean: Floats, covariance: Floats, extent: Told, first_ns: NDArray[np.int64], evidence: Floats,
    confirmed: NDArray[np.bool_], track_id: Ids, group: Ids, cameras: Ids, class_id: Bytes,
    kit: Bytes,
    to_position: Told, to_velocity: Told, to_covariance: Told, to_extent: Told, to_age: Told,
    to_score: Told, to_track_id: Ids, to_group: Ids, to_cameras: Ids, to_member_count: Bytes,
    to_status: Bytes, to_class_id: Bytes, to_kit: Bytes,
) -> None:  # fmt: skip
    for index in range(len(rows)):
        row, to = rows[index], place[index]
        for i in range(2):
            to_position[to, i], to_velocity[to, i] = mean[row, i], mean[row, 2 + i]
            to_extent[to, i] = extent[row, i]
        to_position[to, 2] = 0.0
        for i in range(4):
            for j in range(4):
                to_covariance[to, i, j] = covariance[row, i, j]
        to_age[to] = (stamp_ns - first_ns[row]) / 1e9
        to_score[to] = 1.0 / (1.0 + np.exp(-evidence[row]))
        to_track_id[to], to_group[to], to_cameras[to] = track_id[row], group[row], cameras[row]
        to_member_count[to] = 1
        to_status[to] = _status(confirmed[row], cameras[row], group[row])
        to_class_id[to], to_kit[to] = class_id[row], kit[row]


def status_of(table: TrackTable) -> NDArray[np.uint8]:
    """Return the `TrackStatus` of tracks at a tick."""
    return _status_of(table.confirmed, table.cameras, table.group)


@compiled(types.u1[::1](COLUMN_FLAGS, COLUMN_IDS, COLUMN_IDS))
def _status_of(confirmed: NDArray[np.bool_], cameras: Ids, group: Ids) -> Bytes:
    status = np.empty(len(confirmed), np.uint8)
    for row in range(len(confirmed)):
        status[row] = _status(confirmed[row], cameras[row], group[row])
    return status


def feedback_of(table: TrackTable, entering: NDArray[np.bool_], stamp_ns: int) -> Feedback:
    """Return what cameras are told of tracks, (n,) of which may be entering a view."""
    recent = table.seen_by_ns > stamp_ns - SEEN_MEMORY_NS
    bits = np.left_shift(np.uint32(1), np.arange(recent.shape[1], dtype=np.uint32))
    resolved = (table.group > 0) & (table.cameras > 0)
    flags = resolved * np.uint8(FeedbackFlag.GROUP_RESOLVED)
    flags |= (table.previous_id > 0) * np.uint8(FeedbackFlag.CORRECTED)
    flags |= entering * np.uint8(FeedbackFlag.ENTERING)
    return Feedback.build(
        stamp_ns,
        position=ground_points(table),
        velocity=table.mean[:, 2:],
        covariance=table.covariance,
        extent=table.extent,
        template=table.template,
        track_id=table.track_id,
        previous_id=table.previous_id,
        group=table.group,
        seen_by=(recent * bits).sum(axis=1, dtype=np.uint32),
        flags=flags,
    )


class _Row(NamedTuple):
    event: EventCode
    track_id: int
    position: tuple[float, float, float]
    old_id: int
    new_id: int
    others: list[int]
    probability: float


class EventLog:
    """Collects the events of one tick."""

    def __init__(self) -> None:
        self._rows: list[_Row] = []

    def add(
        self,
        code: EventCode,
        table: TrackTable,
        row: int,
        *,
        old_id: int = 0,
        others: NDArray[np.uint32] | None = None,
        probability: float | None = None,
    ) -> None:
        """Note an event, as probable as its track unless told; a correction names the old id."""
        track_id = int(table.track_id[row])
        x, y = table.mean[row, :2].tolist()
        rest = [] if others is None else others[others != track_id][:MEMBERS].tolist()
        new_id = track_id if old_id else 0
        told = float(expit(table.evidence[row])) if probability is None else probability
        self._rows.append(_Row(code, track_id, (x, y, 0.0), old_id, new_id, rest, told))

    def add_all(self, code: EventCode, table: TrackTable, mask: NDArray[np.bool_]) -> None:
        """Note one event for each track of a mask."""
        (rows,) = mask.nonzero()
        if not len(rows):
            return
        names, places = table.track_id[rows].tolist(), table.mean[rows, :2].tolist()
        for track_id, (x, y), told in zip(names, places, expit(table.evidence[rows]).tolist()):
            self._rows.append(_Row(code, track_id, (x, y, 0.0), 0, 0, [], told))

    def events(self, stamp_ns: int) -> Events:
        """Return the events sorted by code, then track."""
        rows = sorted(self._rows)
        if not rows:
            return Events.build(stamp_ns)
        return Events.build(
            stamp_ns,
            position=[row.position for row in rows],
            probability=[row.probability for row in rows],
            track_id=[row.track_id for row in rows],
            old_id=[row.old_id for row in rows],
            new_id=[row.new_id for row in rows],
            others=[row.others + [0] * (MEMBERS - len(row.others)) for row in rows],
            event=[row.event for row in rows],
        )


def ground_points(table: TrackTable) -> NDArray[np.float64]:
    """Return the (n, 3) positions of tracks, on the ground, m."""
    points = np.zeros((len(table), 3))
    points[:, :2] = table.mean[:, :2]
    return points
