"""What fusion publishes: tracks, feedback, events, each in canonical order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled
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
    table : TrackTable
        The same tracks as they are at the tick, a copy.

    """

    tracks: Tracks
    events: Events
    table: TrackTable

    @property
    def feedback(self) -> Feedback:
        """What the cameras are told; made when asked for: not everybody has cameras to tell."""
        told = self.table.confirmed & (self.tracks.status != TrackStatus.DELETED)
        return feedback_of(self.table.select(told), self.tracks.stamp_ns)


def output_of(
    table: TrackTable,
    is_published: NDArray[np.bool_],
    ended: TrackTable,
    events: Events,
) -> FusionOutput:
    """Return what a tick yields: the published tracks and, once, those that ended, by id."""
    rows, count = np.flatnonzero(is_published), len(table)
    if len(ended):
        table = table.extended(ended)
        rows = np.concatenate([rows, np.arange(count, len(table))])
        rows = rows[np.argsort(table.track_id[rows])]
    table = table.select(rows)
    status = status_of(table)
    status[rows >= count] = TrackStatus.DELETED
    return FusionOutput(tracks_of(table, status, events.stamp_ns), events, table)


def tracks_of(table: TrackTable, status: NDArray[np.uint8], stamp_ns: int) -> Tracks:
    """Return tracks as they are published."""
    return Tracks.build(
        stamp_ns,
        position=ground_points(table),
        velocity=table.mean[:, 2:],
        covariance=table.covariance,
        age=(stamp_ns - table.first_ns) / 1e9,
        score=1 / (1 + np.exp(-table.evidence)),
        track_id=table.track_id,
        group=table.group,
        cameras=table.cameras,
        status=status,
        class_id=table.class_id,
        kit=table.kit,
    )


def status_of(table: TrackTable) -> NDArray[np.uint8]:
    """Return the `TrackStatus` of tracks at a tick."""
    return _status_of(table.confirmed, table.cameras, table.group)


@compiled(
    types.u1[::1](
        types.Array(types.b1, 1, 'A', readonly=True),
        types.Array(types.u4, 1, 'A', readonly=True),
        types.Array(types.u4, 1, 'A', readonly=True),
    )
)
def _status_of(
    confirmed: NDArray[np.bool_], cameras: NDArray[np.uint32], group: NDArray[np.uint32]
) -> NDArray[np.uint8]:
    status = np.empty(len(confirmed), np.uint8)
    for row in range(len(confirmed)):
        if not confirmed[row]:
            status[row] = TrackStatus.TENTATIVE
        elif cameras[row]:
            status[row] = TrackStatus.CONFIRMED
        else:
            status[row] = TrackStatus.GROUPED if group[row] else TrackStatus.COASTING
    return status


def feedback_of(table: TrackTable, stamp_ns: int) -> Feedback:
    """Return what cameras are told of tracks."""
    recent = table.seen_by_ns > stamp_ns - SEEN_MEMORY_NS
    bits = np.left_shift(np.uint32(1), np.arange(recent.shape[1], dtype=np.uint32))
    resolved = (table.group > 0) & (table.cameras > 0)
    flags = resolved * np.uint8(FeedbackFlag.GROUP_RESOLVED)
    flags |= (table.previous_id > 0) * np.uint8(FeedbackFlag.CORRECTED)
    return Feedback.build(
        stamp_ns,
        position=ground_points(table),
        velocity=table.mean[:, 2:],
        covariance=table.covariance,
        template=table.template,
        track_id=table.track_id,
        previous_id=table.previous_id,
        group=table.group,
        seen_by=(recent * bits).sum(axis=1, dtype=np.uint32),
        flags=flags,
    )


class EventLog:
    """Collects the events of one tick."""

    def __init__(self) -> None:
        self._rows: list[tuple[EventCode, int, tuple[float, float], int, int, list[int]]] = []

    def add(
        self,
        code: EventCode,
        table: TrackTable,
        row: int,
        *,
        old_id: int = 0,
        others: NDArray[np.uint32] | None = None,
    ) -> None:
        """Note an event of one track; a correction says what it was called."""
        track_id = int(table.track_id[row])
        x, y = table.mean[row, :2].tolist()
        rest = [] if others is None else others[others != track_id][:MEMBERS].tolist()
        new_id = track_id if old_id else 0
        self._rows.append((code, track_id, (x, y), old_id, new_id, rest))

    def add_all(self, code: EventCode, table: TrackTable, mask: NDArray[np.bool_]) -> None:
        """Note one event for each track of a mask."""
        rows = np.flatnonzero(mask)
        if not len(rows):
            return
        places = map(tuple, table.mean[rows, :2].tolist())
        for track_id, place in zip(table.track_id[rows].tolist(), places):
            self._rows.append((code, track_id, place, 0, 0, []))

    def events(self, stamp_ns: int) -> Events:
        """Return the events sorted by code, then track."""
        rows = sorted(self._rows)
        if not rows:
            return Events.build(stamp_ns)
        return Events.build(
            stamp_ns,
            position=[(*row[2], 0.0) for row in rows],
            track_id=[row[1] for row in rows],
            old_id=[row[3] for row in rows],
            new_id=[row[4] for row in rows],
            others=[row[5] + [0] * (MEMBERS - len(row[5])) for row in rows],
            event=[row[0] for row in rows],
        )


def ground_points(table: TrackTable) -> NDArray[np.float64]:
    """Return the (n, 3) positions of tracks, on the ground, m."""
    points = np.zeros((len(table), 3))
    points[:, :2] = table.mean[:, :2]
    return points
