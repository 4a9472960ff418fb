"""Fusion of all cameras' detections: one step a tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.config import JointConfig
from mctrack_ros.fusion.existence.evidence import Evidence
from mctrack_ros.fusion.joint_tracker.output import EventLog, FusionOutput, feedback_of, tracks_of
from mctrack_ros.fusion.management import lifecycle
from mctrack_ros.fusion.management.duplicates import DuplicateWatch, absorb, alone, close_pairs
from mctrack_ros.fusion.management.initiation import (
    MOST_STARTS,
    new_tracks,
    note_beside,
    with_room,
)
from mctrack_ros.fusion.management.lineage import Lineage
from mctrack_ros.fusion.management.parting import DOUBT, go_on_as, parted
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import motion_of
from mctrack_ros.fusion.neighbours import NearPairs, near_pairs
from mctrack_ros.fusion.reid.clothing_clusters import ClothingClusters
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import match
from mctrack_ros.interfaces import MAX_CAMERAS, EventCode, Feedback, Tick

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

LARGEST_ID = 2**32 - 1
"""Ids travel as 32 bits."""

RESET_S = 1.0
"""Time that steps back by more than this begins anew, s."""


class FusionPipeline:
    """
    Tracks targets on the ground from the detections of all cameras.

    A Kalman filter a target, or two that interact (`motion`); the images of a tick are assigned
    together, each to what prediction and the others say; what no track explains starts tracks
    where cameras agree or one persists.

    Parameters
    ----------
    config : JointConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.

    Attributes
    ----------
    next_id : int
        Id of the next track that begins.
    bias : CameraBias
        How the cameras disagree, in the site's order.

    Raises
    ------
    ValueError
        If there are too many cameras or a name occurs twice.

    """

    def __init__(self, config: JointConfig, cameras: tuple[str, ...], first_id: int = 1) -> None:
        if len(cameras) > MAX_CAMERAS or len(set(cameras)) != len(cameras):
            raise ValueError(f'cameras are {cameras!r}, expected at most {MAX_CAMERAS}, distinct')
        self._config = config
        self._index = {name: index for index, name in enumerate(cameras)}
        self._motion = motion_of(config.motion)
        self._nearby = max(config.recognition.contact_distance, config.life.merge_distance)
        blank = 0, len(cameras), self._motion.modes
        self._table, self._none = TrackTable.blank(*blank), TrackTable.blank(*blank)
        self._evidence = Evidence(len(cameras), config)
        self._lineage = Lineage(config)
        self._reassignment = Reassignment(config)
        self._duplicates = DuplicateWatch(config.life.merge_time)
        self._twins = DuplicateWatch(config.life.twin_time)
        self._kits = ClothingClusters(config)
        self.bias = CameraBias(len(cameras))
        self._stamp_ns: int | None = None
        self.next_id = first_id

    def step(self, tick: Tick, recorder: DecisionRecorder | None = None) -> FusionOutput:
        """
        Process one tick: observe, orient, decide, act.

        These are the steps of the Omnibus cycle (Bedworth and O'Brien 2000, "The Omnibus model"),
        as which the event-tracking paper arranges its server (section 4.3).

        Parameters
        ----------
        tick : Tick
            Later than the last one, or more than a second earlier: then all tracks end.
        recorder : DecisionRecorder, optional
            A new one, which takes down why; what comes out is the same.

        Raises
        ------
        ValueError
            If a camera is not known or the tick's stamp steps back by less than a second.
        OverflowError
            If there may be no ids left for who begins.

        """
        if self.next_id + MOST_STARTS > LARGEST_ID:
            raise OverflowError(f'ids have run out: the next is {self.next_id}; start anew')
        events = EventLog()
        batch, ended = self._observe(tick, events)
        if recorder is not None:
            recorder.begin(tick, self._table, ended, self._config, tuple(self._index))
        groups = self._table.group.copy()
        leftover = self._orient(tick, batch, recorder)
        ended = ended.extended(self._decide(tick, batch, leftover, groups, events, recorder))
        if recorder is not None:
            recorder.end(self._table, ended, self._reassignment)
        return self._act(ended, tick.stamp_ns, events)

    def feedback(self) -> Feedback:
        """Return what the cameras are told after the last tick: a prediction of every target."""
        if self._stamp_ns is None:
            return Feedback.build(0)
        is_expected = lifecycle.is_expected(self._table, self._stamp_ns, self._config)
        reported = self._table.select(self._table.confirmed & is_expected)
        return feedback_of(reported, self._evidence.entering(reported), self._stamp_ns)

    def _observe(self, tick: Tick, events: EventLog) -> tuple[Batch, TrackTable]:
        """Take up the images of a tick and predict the tracks to it; return who ends by that."""
        ended = self._begin(tick.stamp_ns, events)
        images = [message.rows for message in tick.messages]
        gallery = self._reassignment.gallery
        batch = Batch(images, self._cameras(tick), tick.stamp_ns, self._config, gallery)
        self.bias.correct(batch)
        return batch, ended

    def _orient(
        self, tick: Tick, batch: Batch, recorder: DecisionRecorder | None
    ) -> NDArray[np.intp]:
        """Give every image its tracks; return what the last one of each camera has left."""
        left, rows, columns = match(self._table, batch, self._config, self._motion, recorder)
        if self._config.motion.compare_cameras:
            self.bias.learn(self._table, batch, rows, columns, tick.stamp_ns)
        count = len(batch.cameras)
        if len(set(batch.cameras.tolist())) == count:
            return left
        last = np.zeros(len(self._index), np.intp)
        last[batch.cameras] = np.arange(count)
        return np.asarray(left[batch.image[left] == last[batch.camera[left]]])

    def _decide(
        self,
        tick: Tick,
        batch: Batch,
        leftover: NDArray[np.intp],
        groups: NDArray[np.uint32],
        events: EventLog,
        recorder: DecisionRecorder | None,
    ) -> TrackTable:
        """Settle who is in a group, who begins, who is who and who ends; return the last."""
        stamp_ns = tick.stamp_ns
        self._note_groups(groups, stamp_ns, events)
        self._initiate(batch, leftover, stamp_ns)
        if recorder is not None:
            recorder.left(leftover, self._table, batch)
        confirmed = self._evidence.count(self._table, batch, stamp_ns, self._seconds)
        near = near_pairs(self._table.mean, self._nearby)
        changes = self._reassignment.step(self._table, near, stamp_ns, confirmed)
        if changes:
            confirmed = self._rename(changes, confirmed, events)
            near = near_pairs(self._table.mean, self._nearby)
        self._announce(confirmed, events)
        ended = self._merge_duplicates(near, stamp_ns, events)
        ended = ended.extended(self._delete(stamp_ns, events))
        self._kits.step(self._table, stamp_ns)
        return ended

    def _act(self, ended: TrackTable, stamp_ns: int, events: EventLog) -> FusionOutput:
        """Return what is published; the cameras are told by `feedback`."""
        is_published = lifecycle.is_published(self._table, stamp_ns, self._config)
        tracks = tracks_of(self._table, is_published, ended, stamp_ns)
        return FusionOutput(tracks, events.events(stamp_ns))

    def _begin(self, stamp_ns: int, events: EventLog) -> TrackTable:
        """Predict to the tick, or begin anew; return the tracks that end by that."""
        period = self._config.batching.period
        last_ns = stamp_ns - round(period * 1e9) if self._stamp_ns is None else self._stamp_ns
        self._seconds = (stamp_ns - last_ns) / 1e9
        self._stamp_ns = stamp_ns
        if self._seconds < -RESET_S:
            self._seconds = period
            self._reassignment = Reassignment(self._config)
            return self._remove(np.ones(len(self._table), bool), events)
        if self._seconds < 0:
            raise ValueError(f'the tick is stamped {stamp_ns}, expected at least {last_ns}')
        self._motion.predict(self._table, self._seconds)
        self._table.cameras[:] = 0
        self._table.previous_id[:] = 0
        return self._none

    def _cameras(self, tick: Tick) -> list[int]:
        """Return which camera each image is of."""
        for message in tick.messages:
            if message.camera not in self._index:
                known = list(self._index)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
        return [self._index[message.camera] for message in tick.messages]

    def _note_groups(self, before: NDArray[np.uint32], stamp_ns: int, events: EventLog) -> None:
        table = self._table
        if not (np.count_nonzero(before) or np.count_nonzero(table.group)):
            return
        lifecycle.leave_groups(table, stamp_ns)
        for row in np.flatnonzero((before == 0) & (table.group > 0)).tolist():
            group = table.group[row]
            members = table.track_id[(table.group == group) | (table.track_id == group)]
            events.add(EventCode.MERGE, table, row, others=members)
        events.add_all(EventCode.SPLIT, table, (before > 0) & (table.group == 0))

    def _initiate(self, batch: Batch, leftover: NDArray[np.intp], stamp_ns: int) -> None:
        if len(leftover) == 0:
            return
        site = len(self._index), self._config, self._motion
        fresh = new_tracks(batch, leftover, stamp_ns, self.next_id, *site)
        self.next_id += len(fresh)
        fresh, beside = with_room(fresh, self._table, self._config)
        if len(beside):
            fresh.origin[beside] = self._lineage.origins(fresh.mean[beside], self._table, stamp_ns)
        note_beside(fresh, self._table, self._config)
        self._table.append(fresh)

    def _rename(
        self, changes: dict[int, int], confirmed: NDArray[np.bool_], events: EventLog
    ) -> NDArray[np.bool_]:
        """Correct ids; return the newly confirmed who are nobody known, in the table's order."""
        self._lineage.note_found(changes.values())
        order = self._table.rename(changes)
        self._table = table = self._table.select(order)
        changed = np.isin(table.previous_id, list(changes))
        for row in np.flatnonzero(changed).tolist():
            old_id = int(table.previous_id[row])
            certainty = self._reassignment.certainty[old_id]
            events.add(EventCode.CORRECTION, table, row, old_id=old_id, probability=certainty)
        return np.asarray(confirmed[order] & ~changed)

    def _announce(self, confirmed: NDArray[np.bool_], events: EventLog) -> None:
        """Note tracks that are new, or split from one whose past they share."""
        table = self._table
        if not np.count_nonzero(confirmed):
            return
        events.add_all(EventCode.NEW, table, confirmed & (table.origin == 0))
        for row in np.flatnonzero(confirmed & (table.origin > 0)).tolist():
            events.add(EventCode.SPLIT, table, row, old_id=int(table.origin[row]))

    def _merge_duplicates(self, near: NearPairs, stamp_ns: int, events: EventLog) -> TrackTable:
        """Join two tracks of one target, let who has parted go on as another; return who end."""
        table, recognition = self._table, self._reassignment
        joined = self._duplicate_pairs(near, stamp_ns)
        for keep, drop in joined:
            absorb(table, keep, drop)
            recognition.forget(int(table.track_id[drop]))
        busy = {row for pair in joined for row in pair}
        gone_on = parted(table, self._duplicates.doubts(DOUBT), busy, stamp_ns)
        for keep, drop in gone_on:
            go_on_as(table, keep, drop)
            recognition.pass_on(int(table.track_id[drop]), int(table.track_id[keep]))
            self._duplicates.forget(int(table.track_id[keep]))
        if not (joined or gone_on):
            return self._none
        dropped = np.zeros(len(table), bool)
        for keep, drop in joined + gone_on:
            dropped[drop] = True
            if table.confirmed[drop]:
                old_id = int(table.track_id[drop])
                events.add(EventCode.CORRECTION, table, keep, old_id=old_id)
        duplicates = table.track_id[[drop for _, drop in joined]]
        ended = self._remove(dropped, events)
        recognition.note_joined(ended.select(np.isin(ended.track_id, duplicates)), stamp_ns)
        return ended

    def _duplicate_pairs(self, near: NearPairs, stamp_ns: int) -> list[tuple[int, int]]:
        """Return pairs of rows (kept, dropped) that are one; two who are known only if alone."""
        table, seconds = self._table, self._seconds
        close = close_pairs(table, *near, self._config.life.merge_distance, seconds)
        if not len(close.one):
            self._duplicates.clear()
            self._twins.clear()
            return []
        known = self._reassignment.knows(table.track_id[close.one], table.track_id[close.other])
        fresh = close.select(~(known | close.grouped))
        over = lifecycle.is_over(table, stamp_ns, self._config)
        pairs = self._duplicates.find(table, fresh, over, stamp_ns)
        twins = alone(table, close.select(known & ~close.reported), stamp_ns)
        twins = twins._replace(gain=np.full(len(twins.one), seconds))
        return pairs + self._twins.find(table, twins, np.zeros(len(table), bool), stamp_ns)

    def _delete(self, stamp_ns: int, events: EventLog) -> TrackTable:
        lost = self._remove(lifecycle.is_over(self._table, stamp_ns, self._config), events)
        if np.count_nonzero(lost.confirmed):
            self._lineage.note_lost(lost, stamp_ns)
            self._reassignment.note_lost(lost, self._table, stamp_ns)
        return lost

    def _remove(self, mask: NDArray[np.bool_], events: EventLog) -> TrackTable:
        if not np.count_nonzero(mask):
            return self._none
        removed = self._table.remove(mask)
        events.add_all(EventCode.EXIT, removed, removed.confirmed)
        return removed
