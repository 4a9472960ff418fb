"""Fusion of all cameras' detections: one step a tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.config import JointConfig
from mctrack_ros.fusion.existence.evidence import Evidence
from mctrack_ros.fusion.joint_tracker.output import FusionOutput, feedback_of, tracks_of
from mctrack_ros.fusion.management import lifecycle
from mctrack_ros.fusion.management.event_log import EventLog
from mctrack_ros.fusion.management.manager import TrackManager
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import motion_of
from mctrack_ros.fusion.neighbours import NearPairs, near_pairs
from mctrack_ros.fusion.reid.clothing_clusters import ClothingClusters
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import match
from mctrack_ros.interfaces import MAX_CAMERAS, RESTART_NS, EventCode, Feedback, Tick

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder


class JointTracker:
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
        self._existence = Evidence(len(cameras), config)
        self._reid = Reassignment(config)
        self._clothing = ClothingClusters()
        self._manager = TrackManager(config, len(cameras), self._motion, first_id)
        self.bias = CameraBias(len(cameras))
        self._nearby = max(config.recognition.contact_distance, config.life.merge_distance)
        self._table = TrackTable.blank(0, len(cameras), self._motion.modes)
        self._stamp_ns: int | None = None

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._manager.next_id

    def step(self, tick: Tick, recorder: DecisionRecorder | None = None) -> FusionOutput:
        """
        Process one tick.

        The order is that of the Omnibus cycle (Bedworth and O'Brien 2000, "The Omnibus model"):
        observe, orient, decide, act, as which the event-tracking paper arranges its server
        (section 4.3).

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
        events = EventLog()
        ended = self._predict(tick.stamp_ns, events)  # the tracks, to the tick's stamp
        batch = self._measure(tick)  # its detections, without what cameras are known to be off
        if recorder is not None:
            recorder.begin(tick, self._table, ended, self._config, tuple(self._index))
        left = self._associate_and_update(batch, tick.stamp_ns, recorder, events)
        self._manager.begin(self._table, batch, left, self._reid, tick.stamp_ns)
        if recorder is not None:
            recorder.left(left, self._table, batch)
        near, confirmed = self._identify(batch, tick.stamp_ns, events)  # existence, then identity
        self._manager.announce(self._table, confirmed, events)
        ended = ended.extended(self._manage(near, tick.stamp_ns, events))
        if recorder is not None:
            recorder.end(self._table, ended, self._reid)
        return self._publish(ended, tick.stamp_ns, events)

    def feedback(self) -> Feedback:
        """Return what the cameras are told after the last tick: a prediction of every target."""
        if self._stamp_ns is None:
            return Feedback.build(0)
        is_expected = lifecycle.is_expected(self._table, self._stamp_ns, self._config)
        reported = self._table.select(self._table.confirmed & is_expected)
        return feedback_of(reported, self._existence.entering(reported), self._stamp_ns)

    def _predict(self, stamp_ns: int, events: EventLog) -> TrackTable:
        """Predict to the tick, or begin anew; return the tracks that end by that."""
        self._manager.check_ids()
        period = self._config.batching.period
        last_ns = stamp_ns - round(period * 1e9) if self._stamp_ns is None else self._stamp_ns
        self._seconds = (stamp_ns - last_ns) / 1e9
        self._stamp_ns = stamp_ns
        if stamp_ns < last_ns - RESTART_NS:
            self._seconds = period
            self._reid = Reassignment(self._config)
            return self._manager.delete_all(self._table, events)
        if self._seconds < 0:
            raise ValueError(f'the tick is stamped {stamp_ns}, expected at least {last_ns}')
        self._motion.predict(self._table, self._seconds)
        self._table.cameras[:] = 0
        self._table.previous_id[:] = 0
        return self._table.select(np.zeros(len(self._table), bool))

    def _measure(self, tick: Tick) -> Batch:
        """Return the detections of a tick, corrected by what their cameras are known to be off."""
        for message in tick.messages:
            if message.camera not in self._index:
                known = list(self._index)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
        cameras = [self._index[message.camera] for message in tick.messages]
        images = [message.rows for message in tick.messages]
        batch = Batch(images, cameras, tick.stamp_ns, self._config)
        self.bias.correct(batch)
        return batch

    def _associate_and_update(
        self, batch: Batch, stamp_ns: int, recorder: DecisionRecorder | None, events: EventLog
    ) -> NDArray[np.intp]:
        """Give every image its tracks; return what the last image of each camera has left."""
        groups = self._table.group.copy()
        left, rows, columns = match(self._table, batch, self._config, self._motion, recorder)
        if self._config.motion.compare_cameras:
            self.bias.learn(self._table, batch, rows, columns, stamp_ns)
        self._manager.note_groups(self._table, groups, stamp_ns, events)
        count = len(batch.cameras)
        if len(set(batch.cameras.tolist())) == count:
            return left
        last = np.zeros(len(self._index), np.intp)
        last[batch.cameras] = np.arange(count)
        return np.asarray(left[batch.image[left] == last[batch.camera[left]]])

    def _identify(
        self, batch: Batch, stamp_ns: int, events: EventLog
    ) -> tuple[NearPairs, NDArray[np.bool_]]:
        """
        Confirm tracks by what the cameras see of them, and correct ids.

        Returns
        -------
        near : pair of (k,) int arrays
            Rows of those who are near each other.
        confirmed : (n,) bool array
            The newly confirmed that are nobody known.

        """
        confirmed = self._existence.count(self._table, batch, stamp_ns, self._seconds)
        near = near_pairs(self._table.mean, self._nearby)
        changes = self._reid.step(self._table, near, stamp_ns, confirmed)
        if not changes:
            return near, confirmed
        order = self._table.rename(changes)
        self._table = table = self._table.select(order)
        changed = np.isin(table.previous_id, list(changes))
        for row in np.flatnonzero(changed).tolist():
            old_id = int(table.previous_id[row])
            certainty = self._reid.certainty[old_id]
            events.add(EventCode.CORRECTION, table, row, old_id=old_id, probability=certainty)
        return near_pairs(table.mean, self._nearby), np.asarray(confirmed[order] & ~changed)

    def _manage(self, near: NearPairs, stamp_ns: int, events: EventLog) -> TrackTable:
        """Join duplicates, delete what is over, find who is dressed alike; return who ended."""
        table, seconds = self._table, self._seconds
        ended = self._manager.join(table, near, self._reid, stamp_ns, seconds, events)
        ended = ended.extended(self._manager.delete(table, self._reid, stamp_ns, events))
        self._clothing.step(table, stamp_ns)
        return ended

    def _publish(self, ended: TrackTable, stamp_ns: int, events: EventLog) -> FusionOutput:
        """Return what is published; the cameras are told by `feedback`."""
        is_published = lifecycle.is_published(self._table, stamp_ns, self._config)
        tracks = tracks_of(self._table, is_published, ended, stamp_ns)
        return FusionOutput(tracks, events.events(stamp_ns))
