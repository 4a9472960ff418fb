"""Events of one camera, before the server has spoken (event-tracking paper, Table 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import MEMBERS, EventCode, Events
from mctrack_ros.perception.feedback.id_assignment import Identified
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

Ints = NDArray[np.int64]

SEEN = 0.977
"""How probable it is that whom an event names by a track of the camera's own is the right one."""

HIDDEN = 0.82
"""And of a group who is named because the fusion node expects him there."""


@dataclass(frozen=True, slots=True)
class _Row:
    event: int
    local_id: int
    track_id: int
    position: list[float]
    others: list[int]
    other_tracks: list[int]


class EventLog:
    """
    Collects the events of one image.

    An event is as probable as that all whom it names are the right ones. On tuning matches (1 to
    4 and 6, 12,000 merges and splits of the default tracker) the product over its members tells
    how often it is true within .02 wherever it is above .5.

    Parameters
    ----------
    stamp_ns : int
        Time of the image, ns.

    """

    def __init__(self, stamp_ns: int) -> None:
        self._stamp_ns = stamp_ns
        self._rows: list[_Row] = []

    def add(
        self, event: EventCode, tracks: Identified, row: int, others: Ints | None = None
    ) -> None:
        """Note an event of the track in a row, with the local ids of others that share it."""
        named = [] if others is None else others.tolist()[:MEMBERS]
        position = [*tracks.mean[row, :2].tolist(), 0.0]
        local_id, track_id = int(tracks.local_id[row]), int(tracks.track_id[row])
        self._rows.append(_Row(int(event), local_id, track_id, position, named, []))

    def add_target(self, event: EventCode, track_id: int, position: NDArray[np.floating]) -> None:
        """Note an event of a global target, at a (3,) position, m, that has no local track."""
        self._rows.append(_Row(int(event), 0, track_id, position.tolist(), [], []))

    def add_group(self, event: EventCode, in_view: PersonsInView, part: Ints, rest: Ints) -> None:
        """Note that a part of a group joins or leaves the rest, each given by its rows."""
        first = part[(in_view.local_id[part] == 0).argmin()]
        others = np.concatenate([part[part != first], rest])
        others = others[np.argsort(in_view.local_id[others] == 0, kind='stable')][:MEMBERS]
        local_id, track_id = int(in_view.local_id[first]), int(in_view.track_id[first])
        position = [*in_view.position[first].tolist(), 0.0]
        named = in_view.local_id[others].tolist(), in_view.track_id[others].tolist()
        self._rows.append(_Row(int(event), local_id, track_id, position, *named))

    def rows(self) -> Events:
        """Return the events in the order in which they were noted."""
        if not self._rows:
            return Events.build(self._stamp_ns)
        others = np.zeros((2, len(self._rows), MEMBERS), np.uint32)
        for index, row in enumerate(self._rows):
            others[0, index, : len(row.others)] = row.others
            others[1, index, : len(row.other_tracks)] = row.other_tracks
        return Events.build(
            self._stamp_ns,
            position=[row.position for row in self._rows],
            probability=[_probability(row) for row in self._rows],
            event=[row.event for row in self._rows],
            local_id=[row.local_id for row in self._rows],
            track_id=[row.track_id for row in self._rows],
            others=others[0],
            other_tracks=others[1],
        )


def _probability(row: _Row) -> float:
    hidden = [row.local_id, *row.others].count(0) if row.others else 0
    return SEEN ** (1 + len(row.others) - hidden) * HIDDEN**hidden


def feedback_missed(stamp_ns: int) -> Events:
    """Return the event of an image for which the feedback was not there."""
    return Events.build(stamp_ns, event=[int(EventCode.FEEDBACK_MISSED)])
