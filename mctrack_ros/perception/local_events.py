"""Events of one camera, before the server has spoken (event-tracking paper, Table 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import MEMBERS, EventCode, Events
from mctrack_ros.perception.identity import Identified

Ints = NDArray[np.int64]


class EventLog:
    """
    Collects the events of one picture.

    Parameters
    ----------
    stamp_ns : int
        Time of the picture, ns.

    """

    def __init__(self, stamp_ns: int) -> None:
        self._stamp_ns = stamp_ns
        self._rows: list[tuple[int, int, int, list[float], list[int]]] = []

    def add(
        self, event: EventCode, tracks: Identified, row: int, others: Ints | None = None
    ) -> None:
        """Note an event of the track in a row, with the local ids of others that share it."""
        position = [*tracks.mean[row, :2].tolist(), 0.0]
        named = [] if others is None else others.tolist()[:MEMBERS]
        self._rows.append(
            (int(event), int(tracks.local_id[row]), int(tracks.track_id[row]), position, named)
        )

    def add_target(self, event: EventCode, track_id: int, position: NDArray[np.floating]) -> None:
        """Note an event of a global target, at a (3,) position, m, that has no local track."""
        self._rows.append((int(event), 0, track_id, position.tolist(), []))

    def rows(self) -> Events:
        """Return the events in the order in which they were noted."""
        if not self._rows:
            return Events.build(self._stamp_ns)
        event, local_id, track_id, position, named = zip(*self._rows)
        others = np.zeros((len(event), MEMBERS), np.uint32)
        for row, ids in enumerate(named):
            others[row, : len(ids)] = ids
        return Events.build(
            self._stamp_ns,
            position=position,
            event=event,
            local_id=local_id,
            track_id=track_id,
            others=others,
        )


def feedback_missed(stamp_ns: int) -> Events:
    """Return the event of a picture for which the feedback was not there."""
    return Events.build(stamp_ns, event=[int(EventCode.FEEDBACK_MISSED)])
