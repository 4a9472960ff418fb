"""Fusion by belief propagation: targets start by detections and are tracked by particles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief, Target
from mctrack_ros.fusion.inputs import BeliefInput
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.interfaces import (
    REPORTED,
    Belief,
    CameraRows,
    ClassCode,
    Detections,
    EventCode,
    Events,
    RowsTick,
    Tracks,
    TrackStatus,
    starts_anew,
)

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]

APART_M = 0.8
"""Distance to every target from which a detection is of somebody new."""
BOX_NOISE_M = 0.15
"""Added to what is known of a starting position, m: where in a body that is."""


class BeliefTracker:
    """
    Tracks targets by sequential belief propagation between the cameras' particle filters.

    The joint tracker runs beside it on the detections. Whom it confirms away from all targets
    becomes a target, and ends when it has had no track for him for `keep_time`: particles that
    slid off a person look at something for ever.

    Parameters
    ----------
    config : BeliefConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.

    Attributes
    ----------
    ground : GroundBelief
        The targets, and the messages of the last tick.

    """

    bias = None

    def __init__(self, config: BeliefConfig, cameras: tuple[str, ...], first_id: int = 1) -> None:
        self._config, self._cameras = config, cameras
        self._next_id = first_id
        self._asked: list[Detections] = []
        self._begin_anew()

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._next_id

    @next_id.setter
    def next_id(self, next_id: int) -> None:
        self._next_id = next_id

    def start(self, rows: Detections) -> None:
        """
        Start a target where a row is, and end the one whose id a row without position has.

        That is done at the first tick from the rows' stamp on. Who is near a target that there is
        already is taken for that one, so a detector may send all that it sees.
        """
        self._asked.append(rows)

    def step(
        self, tick: RowsTick[BeliefInput], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """
        Process one tick.

        Of several images of a camera the particles of the last one count.

        Raises
        ------
        ValueError
            If a camera is not known.

        """
        ended: dict[int, Target] = {}
        if self.ground.stamp_ns and starts_anew(tick.stamp_ns, self.ground.stamp_ns):
            ended = self.ground.targets
            self._begin_anew()
        for message in tick.messages:
            if message.camera not in self._cameras:
                known = list(self._cameras)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
        views = {message.camera: message.rows.belief for message in tick.messages}
        before = dict(self.ground.targets)
        over = self.ground.step(views, tick.stamp_ns)
        started, asked_to_end = self._take_asked(tick.stamp_ns)
        before |= self.ground.targets
        over += self.ground.end(asked_to_end)
        ended |= {track_id: before[track_id] for track_id in over}
        if self._config.start:
            confirmed, unsupported = self._by_detections(tick)
            started += confirmed
            before |= self.ground.targets
            over += self.ground.end(unsupported)
            ended |= {track_id: before[track_id] for track_id in unsupported}
        return FusionOutput(
            self._tracks(ended, tick.stamp_ns), self._events(started, ended, tick.stamp_ns)
        )

    def feedback(self) -> Belief:
        """Return the particles that cameras are sent after the last tick."""
        return self.ground.belief()

    def _begin_anew(self) -> None:
        self.ground = GroundBelief(self._config)
        self._supported_ns: dict[int, int] = {}
        self._joint = JointTracker(JointConfig(batching=self._config.batching), self._cameras)

    def _started(self, place: Floats, covariance: Floats, velocity: Floats | None = None) -> int:
        track_id, self._next_id = self._next_id, self._next_id + 1
        self.ground.start(track_id, place, covariance, velocity)
        return track_id

    def _take_asked(self, stamp_ns: int) -> tuple[list[int], list[int]]:
        """Start who was asked for up to a stamp, ns; return these, and whose end was asked for."""
        due = [rows for rows in self._asked if rows.stamp_ns <= stamp_ns]
        self._asked = [rows for rows in self._asked if rows.stamp_ns > stamp_ns]
        started, over = [], []
        for rows in due:
            means = self._means()
            place = rows.position[:, :2].astype(np.float64)
            is_start = np.isfinite(place).all(axis=1)
            over += rows.track_id[~is_start].tolist()
            for row in np.flatnonzero(is_start):
                if np.hypot(*(means - place[row]).T).min(initial=np.inf) < APART_M:
                    continue
                covariance = rows.covariance[row] + BOX_NOISE_M**2 * np.eye(2)
                started.append(self._started(place[row], covariance))
        return started, over

    def _by_detections(self, tick: RowsTick[BeliefInput]) -> tuple[list[int], list[int]]:
        """
        Start those whom the joint tracker sees, confirmed, where no target is.

        Return these, and whom of those that were started so it has not had for `keep_time`. Each
        of its tracks is one target's.
        """
        messages = [CameraRows(each.camera, each.rows.detections) for each in tick.messages]
        tracks = self._joint.step(RowsTick(tick.stamp_ns, tuple(messages), tick.record)).tracks
        tracks = tracks.select(np.isin(tracks.status, REPORTED))
        place, means = tracks.position[:, :2].astype(np.float64), self._means()
        gap = np.linalg.norm(means[:, None] - place, axis=2)
        over = self._unsupported(gap, tick.stamp_ns)
        started = []
        for row in np.flatnonzero(tracks.status == TrackStatus.CONFIRMED):
            if np.hypot(*(self._means() - place[row]).T).min(initial=np.inf) >= APART_M:
                covariance = tracks.covariance[row, :2, :2] + BOX_NOISE_M**2 * np.eye(2)
                velocity = tracks.velocity[row].astype(np.float64)
                started.append(self._started(place[row], covariance.astype(np.float64), velocity))
        self._supported_ns |= dict.fromkeys(started, tick.stamp_ns)
        return started, over

    def _unsupported(self, gap: Floats, stamp_ns: int) -> list[int]:
        """Return who was started by detections and has had no track, (t, n) m, for `keep_time`."""
        pairs = zip(*linear_sum_assignment(np.minimum(gap, APART_M)))
        ids = list(self.ground.targets)
        supported = {ids[row] for row, column in pairs if gap[row, column] < APART_M}
        self._supported_ns = {
            key: stamp_ns if key in supported else since_ns
            for key, since_ns in self._supported_ns.items()
            if key in self.ground.targets
        }
        least_ns = stamp_ns - round(self._config.keep_time * 1e9)
        return [key for key, since_ns in self._supported_ns.items() if since_ns < least_ns]

    def _means(self) -> Floats:
        """Return where the targets are, (t, 2) m."""
        means = [target.state[:, :2].mean(axis=0) for target in self.ground.targets.values()]
        return np.array(means).reshape(-1, 2)

    def _tracks(self, ended: dict[int, Target], stamp_ns: int) -> Tracks:
        """Return all targets, and once those that ended, by id."""
        every = dict(sorted((ended | self.ground.targets).items()))
        if not every:
            return Tracks.build(stamp_ns)
        states = np.stack([target.state for target in every.values()])
        motion = states[..., [0, 1, 4, 5]]
        mean = motion.mean(axis=1)
        offset = motion - mean[:, None]
        seen = [sum(1 << self._cameras.index(c) for c in one.seen_by) for one in every.values()]
        status = [
            TrackStatus.DELETED
            if track_id in ended
            else (TrackStatus.CONFIRMED if bits else TrackStatus.COASTING)
            for track_id, bits in zip(every, seen)
        ]
        return Tracks.build(
            stamp_ns,
            position=np.column_stack([mean[:, :2], np.zeros(len(mean))]),
            velocity=mean[:, 2:],
            covariance=np.einsum('tni,tnj->tij', offset, offset) / motion.shape[1],
            extent=states[..., [3, 2]].mean(axis=1),
            age=[(stamp_ns - one.first_ns) * 1e-9 for one in every.values()],
            track_id=list(every),
            cameras=seen,
            status=status,
            class_id=np.full(len(every), ClassCode.PERSON),
        )

    def _events(self, started: list[int], ended: dict[int, Target], stamp_ns: int) -> Events:
        """Return who is new, and who has gone."""
        ids = started + list(ended)
        if not ids:
            return Events.build(stamp_ns)
        every = ended | self.ground.targets
        place = np.array([every[each].state[:, :2].mean(axis=0) for each in ids])
        return Events.build(
            stamp_ns,
            position=np.column_stack([place, np.zeros(len(ids))]),
            track_id=ids,
            event=[EventCode.NEW] * len(started) + [EventCode.EXIT] * len(ended),
        )
