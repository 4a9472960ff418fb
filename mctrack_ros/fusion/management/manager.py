"""Tracks begin, join and end: one object that owns ids, past and doubts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.management import lifecycle
from mctrack_ros.fusion.management.duplicates import MERGE_S, DuplicateWatch, close_pairs
from mctrack_ros.fusion.management.event_log import EventLog
from mctrack_ros.fusion.management.initiation import (
    MOST_STARTS,
    ask_more,
    new_tracks,
    with_room,
)
from mctrack_ros.fusion.management.lineage import MEMORY_S, origins
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import Motion
from mctrack_ros.fusion.neighbours import NearPairs
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import EventCode

LARGEST_ID = 2**32 - 1
"""Ids travel as 32 bits."""

Mask = NDArray[np.bool_]


class TrackManager:
    """
    Begins, joins and ends tracks, and notes the events of it.

    Parameters
    ----------
    config : JointConfig
        Parameters.
    cameras : int
        How many there are.
    motion : Motion
        How tracks move.
    first_id : int
        Id of the first track; those of later ones ascend from it.

    Attributes
    ----------
    next_id : int
        Id of the next track that begins.

    """

    def __init__(self, config: JointConfig, cameras: int, motion: Motion, first_id: int) -> None:
        self._config = config
        self._cameras = cameras
        self._motion = motion
        self._duplicates = DuplicateWatch(MERGE_S)
        self.next_id = first_id

    def check_ids(self) -> None:
        """Raise OverflowError if there may be no ids left for the tracks that begin in a tick."""
        if self.next_id + MOST_STARTS > LARGEST_ID:
            raise OverflowError(f'ids have run out: the next is {self.next_id}; start anew')

    def begin(
        self,
        table: TrackTable,
        batch: Batch,
        left: NDArray[np.intp],
        reid: Reassignment,
        stamp_ns: int,
    ) -> None:
        """
        Begin tracks from what no track took.

        Parameters
        ----------
        table : TrackTable
            The tracks; new ones are appended.
        batch : Batch
            The tick's detections.
        left : (k,) array
            Those that no track took.
        reid : Reassignment
            Knows who was lost.
        stamp_ns : int
            The tick's stamp, ns.

        """
        if len(left) == 0:
            return
        site = self._cameras, self._config, self._motion
        fresh = new_tracks(batch, left, stamp_ns, self.next_id, *site)
        self.next_id += len(fresh)
        fresh, beside = with_room(fresh, table, self._config)
        if len(beside):
            lost = reid.lost.lately(stamp_ns, MEMORY_S)
            fresh.origin[beside] = origins(fresh.mean[beside], table, lost, stamp_ns)
            ask_more(fresh, table)
        table.append(fresh)

    def note_groups(
        self, table: TrackTable, before: NDArray[np.uint32], stamp_ns: int, events: EventLog
    ) -> None:
        """Note who has come into a group and who has left one; `before` holds the (n,) groups."""
        if not (np.count_nonzero(before) or np.count_nonzero(table.group)):
            return
        lifecycle.leave_groups(table, stamp_ns)
        for row in np.flatnonzero((before == 0) & (table.group > 0)).tolist():
            group = table.group[row]
            members = table.track_id[(table.group == group) | (table.track_id == group)]
            events.add(EventCode.MERGE, table, row, others=members)
        events.add_all(EventCode.SPLIT, table, (before > 0) & (table.group == 0))

    def note_corrections(
        self, table: TrackTable, mask: Mask, certainty: dict[int, float], events: EventLog
    ) -> None:
        """Note corrected tracks of a mask (n,), with the certainty by old id."""
        for row in np.flatnonzero(mask).tolist():
            old_id = int(table.previous_id[row])
            sure = certainty[old_id]
            events.add(EventCode.CORRECTION, table, row, old_id=old_id, probability=sure)

    def announce(self, table: TrackTable, confirmed: Mask, events: EventLog) -> None:
        """Note the (n,) newly confirmed: as new, or split from a track whose past they share."""
        if not np.count_nonzero(confirmed):
            return
        events.add_all(EventCode.NEW, table, confirmed & (table.origin == 0))
        for row in np.flatnonzero(confirmed & (table.origin > 0)).tolist():
            events.add(EventCode.SPLIT, table, row, old_id=int(table.origin[row]))

    def join(
        self,
        table: TrackTable,
        near: NearPairs,
        reid: Reassignment,
        stamp_ns: int,
        seconds: float,
        events: EventLog,
    ) -> TrackTable:
        """
        Join two tracks of one target.

        Parameters
        ----------
        table : TrackTable
            The tracks; those that are joined to others are taken out.
        near : pair of (k,) int arrays
            Rows of those near each other, by `merge_distance` at least.
        reid : Reassignment
            Forgets those who are another.
        stamp_ns : int
            The tick's stamp, ns.
        seconds : float
            Time since the last tick, s.
        events : EventLog
            Takes the corrections and exits.

        Returns
        -------
        TrackTable
            The tracks that ended.

        """
        joined = self._duplicate_pairs(table, near, stamp_ns, seconds)
        for keep, drop in joined:
            table.absorb(keep, drop)
            reid.forget(int(table.track_id[drop]))
        return self._correct(table, joined, events)

    def delete(
        self, table: TrackTable, reid: Reassignment, stamp_ns: int, events: EventLog
    ) -> TrackTable:
        """Delete the tracks that nothing has supported for long; return them."""
        lost = _removed(table, lifecycle.is_over(table, stamp_ns, self._config), events)
        if np.count_nonzero(lost.confirmed):
            reid.note_lost(lost, table, stamp_ns)
        return lost

    def delete_all(self, table: TrackTable, events: EventLog) -> TrackTable:
        """Delete all tracks, since time begins anew; return them."""
        return _removed(table, np.ones(len(table), bool), events)

    @staticmethod
    def rename(table: TrackTable, changes: dict[int, int]) -> NDArray[np.intp]:
        """Change ids, old to new, all at once; return the order by which they ascend."""
        changed = np.isin(table.track_id, list(changes))
        table.previous_id[changed] = table.track_id[changed]
        for ids in (table.track_id, table.group, table.origin):
            ids[:] = [changes.get(one, one) for one in ids.tolist()]
        return np.argsort(table.track_id)

    def _duplicate_pairs(
        self, table: TrackTable, near: NearPairs, stamp_ns: int, seconds: float
    ) -> list[tuple[int, int]]:
        """Return pairs of rows (kept, dropped) that are one; two seen alone never are."""
        close = close_pairs(table, *near, self._config.management.merge_distance, seconds)
        if not len(close.one):
            self._duplicates.clear()
            return []
        known = (table.gallery_s[close.one] > 0.0) & (table.gallery_s[close.other] > 0.0)
        fresh = close.select(~(known | close.grouped))
        over = lifecycle.is_over(table, stamp_ns, self._config)
        return self._duplicates.find(table, fresh, over)

    def _correct(
        self, table: TrackTable, pairs: list[tuple[int, int]], events: EventLog
    ) -> TrackTable:
        """Take the second of each pair (kept, dropped) of rows out; return those."""
        dropped = np.zeros(len(table), bool)
        for keep, drop in pairs:
            dropped[drop] = True
            if table.confirmed[drop]:
                old_id = int(table.track_id[drop])
                events.add(EventCode.CORRECTION, table, keep, old_id=old_id)
        return _removed(table, dropped, events)


def _removed(table: TrackTable, mask: Mask, events: EventLog) -> TrackTable:
    """Take the tracks of a mask out of the table, note their exit, and return them."""
    if not np.count_nonzero(mask):
        return table.select(mask)
    removed = table.remove(mask)
    events.add_all(EventCode.EXIT, removed, removed.confirmed)
    return removed
