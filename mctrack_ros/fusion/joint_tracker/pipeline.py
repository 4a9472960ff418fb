"""Fusion of all cameras' detections: one step a tick."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.existence.evidence import Evidence
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import (
    FusionOutput,
    Gates,
    feedback_of,
    gates_of,
    tracks_of,
)
from mctrack_ros.fusion.management import lifecycle
from mctrack_ros.fusion.management.event_log import EventLog
from mctrack_ros.fusion.management.manager import TrackManager
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import motion_of, predict_unwatched
from mctrack_ros.fusion.neighbours import NearPairs, near_pairs
from mctrack_ros.fusion.reid.clothing_clusters import ClothingClusters
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import match
from mctrack_ros.interfaces import MAX_CAMERAS, Feedback, Tick, starts_anew

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

BLIND_S = 4.0
"""Tracks outlast a time without ticks that is longer than this, s; after a shorter one the usual
prediction tells who is still there from who is new."""


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
        self._may_start = _trusted(config.untrusted, cameras)
        self._motion = motion_of(config.motion)
        self._existence = Evidence(len(cameras), config)
        self._reid = Reassignment(config)
        self._clothing = ClothingClusters()
        self._manager = TrackManager(config, len(cameras), self._motion, first_id)
        self.bias = CameraBias(len(cameras))
        self._table = TrackTable.blank(0, len(cameras), self._motion.modes)
        self._stamp_ns: int | None = None

    @property
    def _nearby(self) -> float:
        """How near tracks are to each other that matter to each other, m."""
        config = self._config
        return max(config.reid.contact_distance, config.management.merge_distance)

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._manager.next_id

    @next_id.setter
    def next_id(self, next_id: int) -> None:
        self._manager.next_id = next_id

    def step(self, tick: Tick, recorder: DecisionRecorder | None = None) -> FusionOutput:
        """
        Process one tick.

        The order is that of the Omnibus cycle (Bedworth and O'Brien 2000, "The Omnibus model"),
        as in the server of the event-tracking paper (section 4.3).

        Parameters
        ----------
        tick : Tick
            Later than the last one, or more than a second earlier: then all tracks end.
        recorder : DecisionRecorder, optional
            A new one, which records why; the output is the same.

        Raises
        ------
        ValueError
            If a camera is not known or the tick's stamp steps back by less than a second.
        OverflowError
            If there may be no ids left for who begins.

        """
        now = _Step(_seeing(tick), recorder)
        self._predict(now)  # tracks to the tick's stamp
        self._measure(now)  # detections as measurements on the ground
        self._associate_and_update(now)  # pairs in all images, then the filters
        self._begin(now)  # tracks of detections that nobody explains
        self._confirm(now)  # by the log-odds of existence
        self._identify(now)  # ids corrected after encounters, the lost found again
        self._manage(now)  # duplicates merged, the gone deleted
        return self._publish(now)

    def feedback(self) -> Feedback:
        """Return the feedback after the last tick: a prediction of every target."""
        if self._stamp_ns is None:
            return Feedback.build(0)
        is_expected = lifecycle.is_expected(self._table, self._stamp_ns, self._config)
        reported = self._table.select(self._table.confirmed & is_expected)
        return feedback_of(reported, self._stamp_ns)

    def _predict(self, now: _Step) -> None:
        """Predict the tracks to the tick's stamp; end them all if time begins anew."""
        self._manager.check_ids()
        period = self._config.batching.period
        stamp_ns, last_ns = now.tick.stamp_ns, self._stamp_ns
        if last_ns is None:
            last_ns = stamp_ns - round(period * 1e9)
        self._stamp_ns, now.seconds = stamp_ns, (stamp_ns - last_ns) / 1e9
        if starts_anew(stamp_ns, last_ns):
            now.seconds, self._reid = period, Reassignment(self._config)
            now.ended = self._manager.delete_all(self._table, now.events)
        elif now.seconds < 0:
            raise ValueError(f'the tick is stamped {stamp_ns}, expected at least {last_ns}')
        else:
            if now.seconds > BLIND_S + period:
                predict_unwatched(self._table, now.seconds)
                self._table.kept_ns += round((now.seconds - period) * 1e9)
            else:
                self._motion.predict(self._table, now.seconds)
            now.ended = self._table.select(np.zeros(len(self._table), bool))
        self._table.cameras[:] = 0
        self._table.previous_id[:] = 0

    def _measure(self, now: _Step) -> None:
        """Admit the detections, and correct them by the known bias of their cameras."""
        messages, known = now.tick.messages, list(self._index)
        for message in messages:
            if message.camera not in self._index:
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
        cameras = [self._index[message.camera] for message in messages]
        images = [message.rows for message in messages]
        now.batch = Batch(images, cameras, now.tick.stamp_ns, self._config)
        self.bias.correct(now.batch)
        if now.recorder is not None:
            now.recorder.begin(now.tick, self._table, now.ended, self._config, tuple(known))

    def _associate_and_update(self, now: _Step) -> None:
        """Associate all images with the tracks, update these, and note who is in a group."""
        batch, groups, stamp_ns = now.batch, self._table.group.copy(), now.tick.stamp_ns
        now.left, is_gated, rows, columns = match(
            self._table, batch, self._config, self._motion, now.recorder
        )
        now.gates = gates_of(batch.camera, now.left, is_gated, len(self._index))
        if self._config.motion.compare_cameras:
            self.bias.learn(self._table, batch, rows, columns, stamp_ns)
        self._manager.note_groups(self._table, groups, stamp_ns, now.events)

    def _begin(self, now: _Step) -> None:
        """Begin tracks from what no track took, in the last image of each camera."""
        batch, count = now.batch, len(now.batch.cameras)
        if len(set(batch.cameras.tolist())) < count:
            last = np.zeros(len(self._index), np.intp)
            last[batch.cameras] = np.arange(count)
            now.left = now.left[batch.image[now.left] == last[batch.camera[now.left]]]
        if not self._may_start.all():
            now.left = now.left[self._may_start[batch.camera[now.left]]]
        self._manager.begin(self._table, batch, now.left, self._reid, now.tick.stamp_ns)
        if now.recorder is not None:
            now.recorder.left(now.left, self._table, batch)

    def _confirm(self, now: _Step) -> None:
        """Count the evidence that tracks exist, and confirm."""
        stamp_ns = now.tick.stamp_ns
        now.confirmed = self._existence.count(self._table, now.batch, stamp_ns, now.seconds)

    def _identify(self, now: _Step) -> None:
        """Correct ids; announce the newly confirmed that are nobody known."""
        now.near = near_pairs(self._table.mean, self._nearby)
        changes = self._reid.step(self._table, now.near, now.tick.stamp_ns, now.confirmed)
        if changes:
            order = self._manager.rename(self._table, changes)
            self._table = self._table.select(order)
            corrected = np.isin(self._table.previous_id, list(changes))
            certainty = self._reid.certainty
            self._manager.note_corrections(self._table, corrected, certainty, now.events)
            now.near = near_pairs(self._table.mean, self._nearby)
            now.confirmed = now.confirmed[order] & ~corrected
        self._manager.announce(self._table, now.confirmed, now.events)

    def _manage(self, now: _Step) -> None:
        """Merge duplicates, delete what is over, cluster clothing."""
        table, reid, stamp_ns, events = self._table, self._reid, now.tick.stamp_ns, now.events
        joined = self._manager.join(table, now.near, reid, stamp_ns, now.seconds, events)
        over = self._manager.delete(table, reid, stamp_ns, events)
        now.ended = now.ended.extended(joined.extended(over))
        self._clothing.step(table, stamp_ns)
        if now.recorder is not None:
            now.recorder.end(table, now.ended, reid)

    def _publish(self, now: _Step) -> FusionOutput:
        """Return what is published; cameras receive `feedback`."""
        stamp_ns = now.tick.stamp_ns
        is_published = lifecycle.is_published(self._table, stamp_ns, self._config)
        tracks = tracks_of(self._table, is_published, now.ended, stamp_ns)
        return FusionOutput(tracks, now.events.events(stamp_ns), gates=now.gates)


class _Step:
    """
    One tick on its way through the stages.

    Attributes
    ----------
    tick : Tick
    recorder : DecisionRecorder, optional
    events : EventLog
    seconds : float
        Since the last tick, s.
    batch : Batch
        The detections.
    left : (k,) int array
        Those that no track took.
    gates : Gates
        What became of them all.
    confirmed : (n,) bool array
        The newly confirmed tracks.
    near : pair of (k,) int arrays
        Rows of tracks near each other.
    ended : TrackTable
        Tracks that ended.

    """

    seconds: float
    batch: Batch
    left: NDArray[np.intp]
    gates: Gates
    confirmed: NDArray[np.bool_]
    near: NearPairs
    ended: TrackTable

    def __init__(self, tick: Tick, recorder: DecisionRecorder | None) -> None:
        self.tick, self.recorder, self.events = tick, recorder, EventLog()


def _seeing(tick: Tick) -> Tick:
    """Return a tick without the messages of cameras that cannot tell who is there."""
    if not any(message.rows.is_blind for message in tick.messages):
        return tick
    seeing = tuple(message for message in tick.messages if not message.rows.is_blind)
    return replace(tick, messages=seeing)


def _trusted(untrusted: str, cameras: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return which cameras, (n,), may start tracks."""
    named = {each.strip() for each in untrusted.split(',')} - {''}
    if unknown := sorted(named - set(cameras)):
        raise ConfigError(
            f'untrusted names {", ".join(unknown)}, expected cameras of {", ".join(cameras)}'
        )
    return np.array([name not in named for name in cameras], np.bool_)
