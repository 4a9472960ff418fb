"""The events of one tick: tracks that begin, merge, split, are corrected, end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import MEMBERS, EventCode, Events


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
        """Note an event, as probable as its track unless given; a correction names the old id."""
        track_id = int(table.track_id[row])
        x, y = table.mean[row, :2].tolist()
        rest = [] if others is None else others[others != track_id][:MEMBERS].tolist()
        new_id = track_id if old_id else 0
        reported = float(expit(table.evidence[row])) if probability is None else probability
        self._rows.append(_Row(code, track_id, (x, y, 0.0), old_id, new_id, rest, reported))

    def add_all(self, code: EventCode, table: TrackTable, mask: NDArray[np.bool_]) -> None:
        """Note one event for each track of a mask."""
        (rows,) = mask.nonzero()
        if not len(rows):
            return
        names, places = table.track_id[rows].tolist(), table.mean[rows, :2].tolist()
        for track_id, (x, y), reported in zip(names, places, expit(table.evidence[rows]).tolist()):
            self._rows.append(_Row(code, track_id, (x, y, 0.0), 0, 0, [], reported))

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
