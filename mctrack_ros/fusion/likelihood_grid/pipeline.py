"""Fusion of the cameras' likelihoods: maxima, or the people who explain all layers, tracked."""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.inputs import GridInput
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.likelihood_grid.config import LikelihoodGridConfig
from mctrack_ros.fusion.likelihood_grid.grid import JointGrid
from mctrack_ros.fusion.likelihood_grid.targets import (
    NOISE_M,
    Measured,
    Targets,
    begun,
    matched,
    predicted,
)
from mctrack_ros.fusion.occupancy.config import PeopleConfig
from mctrack_ros.fusion.occupancy.masks import OLDEST_NS, Masks, Unusable, prior_of
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.views import OpenViews
from mctrack_ros.interfaces import (
    NO_EDGE,
    TEMPLATE_SIZE,
    CameraRows,
    ClassCode,
    Detections,
    EventCode,
    Events,
    Feedback,
    Likelihood,
    RowsTick,
    Tracks,
    TrackStatus,
    starts_anew,
)

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]

EDGE_GAIN, USUAL_EDGES = 0.05, 0.4
"""What outlines that are met in full add to the gain of a person, and at which share of that they
speak neither for nor against him: in a crowd edges are everywhere. Terrace to frame 1250, each
image by itself, MODA at 0.5 m: .917 without, .934, .939, .942 with .05, .1, .2. The indoor scene,
seed 1, tracked, MOTA: .988, .992, .964, .948."""
CELL_M = 0.1
"""Distance of the places where the masks are explained. Terrace to frame 1250, tracked, IDF1: .809
with 0.15, .973 with 0.1; the indoor scene, seeds 1, 2, 4, MOTA: .982, .909, .928 and .995, .908,
.903."""
LONGEST_S = 1.0
"""A gap counts for so long at most, s."""
LEAST_S = 1e-6
"""A counter that has run down to this is empty, s."""
SEEN = -3.0
"""Log-likelihood from which a camera counts as seeing somebody."""


class LikelihoodGridTracker:
    """
    Finds people by the likelihoods of all cameras and tracks them (likelihood-grid paper).

    By edges alone, people are the local maxima of the smoothed product (section 4.4). With the
    layer that the last section asks for, background subtraction, they are those who together
    explain all masks, and whose outlines are met by edges. Either way a person is a measurement
    for Algorithm 1.

    Parameters
    ----------
    config : LikelihoodGridConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.
    views : callable
        Reads how the cameras see the ground, for the masks.

    Raises
    ------
    ConfigError, CalibrationError
        If that has to be known, and is not.

    """

    bias = None

    def __init__(
        self,
        config: LikelihoodGridConfig,
        cameras: tuple[str, ...],
        first_id: int,
        views: OpenViews,
    ) -> None:
        self._config, self._cameras = config, cameras
        self._scene: Scene | None = None
        if config.layers == 'both':
            people = PeopleConfig(cell=CELL_M, person_width=config.person_width)
            self._scene = Scene(views(), cameras, people)
            self._masks = Masks(cameras, self._scene, people.person_cost)
        self._targets = Targets()
        self._next_id = first_id
        self._last: dict[str, Likelihood] = {}
        self._stamp_ns: int | None = None

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._next_id

    @next_id.setter
    def next_id(self, next_id: int) -> None:
        self._next_id = next_id

    def step(
        self, tick: RowsTick[GridInput], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """
        Process one tick.

        A camera without a new message counts with its last one for `OLDEST_NS`.

        Raises
        ------
        ValueError
            If a camera is not known, or cameras tell of different cells.

        """
        reset, seconds = self._begin(tick)
        targets = predicted(self._targets, seconds)
        left_out = {} if self._scene is None else self._left_out(tick)
        measured = self._measured(tick, targets, left_out)
        known = self._targets.track_id[self._targets.confirmed]
        over = self._update(targets, measured, seconds)
        ended = reset.followed_by(over)
        ended = ended.select(ended.confirmed)
        now = self._targets.select(self._targets.confirmed)
        risen = now.select(~np.isin(now.track_id, known))
        events = _events(risen, ended, tick.stamp_ns)
        return FusionOutput(self._tracks(ended, tick.stamp_ns), events, dict(left_out))

    def feedback(self) -> Feedback:
        """Return what the cameras are told after the last tick: every confirmed target."""
        targets = self._targets.select(self._targets.confirmed)
        return Feedback.build(
            self._stamp_ns or 0,
            position=_ground(targets),
            velocity=targets.mean[:, 2:],
            covariance=targets.covariance,
            template=targets.template,
            track_id=targets.track_id,
        )

    def _begin(self, tick: RowsTick[GridInput]) -> tuple[Targets, float]:
        """Return the targets that a step back in time ends, and the time since the last tick."""
        last_ns, self._stamp_ns = self._stamp_ns, tick.stamp_ns
        period = self._config.batching.period
        if last_ns is None:
            return Targets(), period
        if starts_anew(tick.stamp_ns, last_ns):
            ended, self._targets, self._last = self._targets, Targets(), {}
            return ended, period
        return Targets(), float(np.clip((tick.stamp_ns - last_ns) * 1e-9, 0.0, LONGEST_S))

    def _measured(
        self, tick: RowsTick[GridInput], targets: Targets, left_out: dict[str, Unusable]
    ) -> Measured:
        """Return where people are by all cameras that count, with the colours there."""
        grid = self._joint_grid(tick, left_out)
        if self._scene is None:
            position, noise = self._maxima(grid)
        else:
            position, noise = self._explained(self._scene, grid, targets, left_out)
        return Measured(position, noise, _colours(position, tick))

    def _update(self, targets: Targets, measured: Measured, seconds: float) -> Targets:
        """Match predicted targets, begin those of what is free, and return those that end."""
        targets = matched(targets, measured, seconds, self._config.targets)
        lives = targets.counter_s > LEAST_S
        free = np.setdiff1d(np.arange(len(measured.position)), targets.measurement)
        new = begun(measured.select(free), self._next_id, self._stamp_ns or 0, seconds)
        self._next_id += len(new)
        self._targets = targets.select(lives).followed_by(new)
        return targets.select(~lives)

    def _left_out(self, tick: RowsTick[GridInput]) -> dict[str, Unusable]:
        """Take the masks; return which cameras do not count, and why: their edges lie, too."""
        received = [CameraRows(each.camera, each.rows.foreground) for each in tick.messages]
        self._masks.take(received, tick.stamp_ns)
        return self._masks.left_out(tick.stamp_ns)

    def _joint_grid(self, tick: RowsTick[GridInput], left_out: Container[str]) -> JointGrid | None:
        """Return the likelihoods of the cameras that know any, but for those left out."""
        for message in tick.messages:
            if message.camera not in self._cameras:
                known = list(self._cameras)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
            self._last[message.camera] = message.rows.likelihood
        received = [
            self._last[camera]
            for camera in self._cameras
            if camera in self._last
            and camera not in left_out
            and len(self._last[camera])
            and tick.stamp_ns - self._last[camera].stamp_ns <= OLDEST_NS
        ]
        return JointGrid(received) if received else None

    def _maxima(self, grid: JointGrid | None) -> tuple[Floats, Floats]:
        """Return where people are by edges alone, (n, 2) m, and covariances, (n, 2, 2) m²."""
        if grid is None:
            return np.zeros((0, 2)), np.zeros((0, 2, 2))
        found = grid.maxima(self._config.least_likelihood)
        return found.position, np.tile(NOISE_M**2 * np.eye(2), (len(found.position), 1, 1))

    def _explained(
        self,
        scene: Scene,
        grid: JointGrid | None,
        targets: Targets,
        left_out: dict[str, Unusable],
    ) -> tuple[Floats, Floats]:
        """Return where people are by masks and edges, (n, 2) m, and covariances, (n, 2, 2) m²."""
        prior = prior_of(targets.mean[targets.confirmed, :2], scene.position)
        if grid is not None:
            prior += EDGE_GAIN * (1 - grid.at(scene.position) / NO_EDGE - USUAL_EDGES)
        people = self._masks.explained(left_out, prior, self._stamp_ns or 0)
        return people.mean, people.covariance + NOISE_M**2 * np.eye(2)

    def _tracks(self, ended: Targets, stamp_ns: int) -> Tracks:
        """Return all targets, and once those that ended."""
        targets = self._targets.followed_by(ended)
        status = np.where(targets.measurement >= 0, TrackStatus.CONFIRMED, TrackStatus.COASTING)
        status[~targets.confirmed] = TrackStatus.TENTATIVE
        status[len(self._targets) :] = TrackStatus.DELETED
        tracks = Tracks.build(
            stamp_ns,
            position=_ground(targets),
            velocity=targets.mean[:, 2:],
            covariance=targets.covariance,
            age=(stamp_ns - targets.first_ns) * 1e-9,
            score=np.clip(targets.counter_s / max(self._config.targets.keep_time, 1e-9), 0, 1),
            track_id=targets.track_id,
            cameras=self._seen_by(targets),
            status=status,
            class_id=np.full(len(targets), ClassCode.PERSON),
        )
        return tracks.select(np.argsort(tracks.track_id, kind='stable'))

    def _seen_by(self, targets: Targets) -> NDArray[np.uint32]:
        """Return the bits of the cameras whose edges fit a measured target."""
        bits = np.zeros(len(targets), np.uint32)
        for index, camera in enumerate(self._cameras):
            own = self._last.get(camera)
            if own is None or not len(own) or not len(targets):
                continue
            place = own.position[:, :2].astype(np.float64)
            nearest = ((place - targets.mean[:, None, :2]) ** 2).sum(axis=2).argmin(axis=1)
            seen = own.log_likelihood[nearest] >= SEEN
            bits |= np.where(
                seen & (targets.measurement >= 0), np.uint32(1 << index), np.uint32(0)
            )
        return bits


def _colours(position: Floats, tick: RowsTick[GridInput]) -> Floats:
    """Return the colours that cameras saw nearest to people, (n, 48); zero: none."""
    colours = np.zeros((len(position), TEMPLATE_SIZE))
    received = [message.rows.detections for message in tick.messages]
    seen = Detections.joined(tick.stamp_ns, received)
    seen = seen.select(np.flatnonzero(seen.template.any(axis=1)))
    if not len(position) or not len(seen):
        return colours
    gap = np.linalg.norm(seen.position[:, None, :2] - position, axis=2)
    np.add.at(colours, gap.argmin(axis=1), seen.template)
    return np.asarray(colours / np.maximum(colours.sum(axis=1, keepdims=True), 1e-9))


def _events(risen: Targets, ended: Targets, stamp_ns: int) -> Events:
    """Return who is new, and who has gone."""
    code = [EventCode.NEW] * len(risen) + [EventCode.EXIT] * len(ended)
    both = risen.followed_by(ended)
    return Events.build(stamp_ns, position=_ground(both), track_id=both.track_id, event=code)


def _ground(targets: Targets) -> Floats:
    """Return the (n, 3) positions of targets, m."""
    return np.column_stack([targets.mean[:, :2], np.zeros(len(targets))])
