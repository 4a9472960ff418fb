"""Fusion of the cameras' masks: people who explain them all, tracked as the joint tracker does."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.occupancy.config import OccupancyConfig
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.occupancy.sighting import Sighting
from mctrack_ros.fusion.occupancy.solver import Occupancy, solve
from mctrack_ros.fusion.views import OpenViews
from mctrack_ros.interfaces import (
    RESTART_NS,
    CameraRows,
    Detections,
    Feedback,
    Foreground,
    RowsTick,
    Tracks,
)

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]

ALL = 'all'
"""What the cameras together are called where decisions are explained."""
OLDEST_NS = 300_000_000
"""The last mask of a camera counts for so long, ns: of one that is slower than others."""
MOST_FOREGROUND = 0.6
"""Share of a mask above which its camera is dazzled and left out."""
FROZEN_NS = 5_000_000_000
"""For how long a mask with foreground may be the same to the pixel, ns."""
PRIOR_GAIN, PRIOR_SIGMA_M = 0.03, 0.3
"""What a predicted track adds to the gain of a person there, and how far from it, m."""
NEAR_M = 0.7
"""How near to a person the detection must be that tells his colours, m."""
LEAST_SUPPORT = 0.5
"""Share of a person's box that must be foreground in a camera that sees him."""


class Unusable(StrEnum):
    """Why a camera's mask is left out."""

    SILENT = f'it sent no mask for {OLDEST_NS * 1e-9:g} s'
    UNKNOWN = 'it does not know its background, or has moved'
    DAZZLED = f'more than {MOST_FOREGROUND:.0%} of its image is foreground'
    FROZEN = f'its mask has not changed for {FROZEN_NS * 1e-9:g} s'


class OccupancyTracker:
    """
    Finds people by the masks of all cameras together and tracks them.

    The likelihood-grid paper's last section asks for background subtraction as another layer of
    its grid. Here it is the only one: the set of people that explains all masks is one detection
    each for `JointTracker`.

    Parameters
    ----------
    config : OccupancyConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.
    views : callable
        Reads how the cameras see the ground.

    Raises
    ------
    ConfigError, CalibrationError
        If that is not known, or no camera sees anybody anywhere.
    ValueError
        If there are too many cameras or a name occurs twice.

    """

    bias = None

    def __init__(
        self, config: OccupancyConfig, cameras: tuple[str, ...], first_id: int, views: OpenViews
    ) -> None:
        self._cameras, self._cost = cameras, config.people.person_cost
        self._scene = Scene(views(), cameras, config.people)
        self._joint = JointTracker(config, (ALL,), first_id)
        self._last: dict[str, Foreground] = {}
        self._changed_ns: dict[str, int] = {}
        self._stamp_ns: int | None = None

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._joint.next_id

    def step(
        self, tick: RowsTick[Sighting], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """
        Process one tick; see `JointTracker.step`.

        A camera without a new mask counts with its last one for `OLDEST_NS`; one whose mask is
        nearly all foreground, frozen or unknown does not count, which the output says.
        """
        self._take(tick)
        left_out = self._left_out(tick.stamp_ns)
        used = np.array([camera not in left_out for camera in self._cameras])
        people = self._explain(used, tick.stamp_ns)
        detections = self._detections(people, tick)
        joint = RowsTick(tick.stamp_ns, (CameraRows(ALL, detections),), tick.record)
        output = self._joint.step(joint, recorder)
        return replace(output, tracks=self._seen_by(output.tracks, people), left_out=left_out)

    def feedback(self) -> Feedback:
        """Return the feedback after the last tick: a prediction of every target."""
        return self._joint.feedback()

    def _take(self, tick: RowsTick[Sighting]) -> None:
        """Keep the masks of a tick, and when they changed last."""
        last_ns, self._stamp_ns = self._stamp_ns, tick.stamp_ns
        if last_ns is not None and tick.stamp_ns < last_ns - RESTART_NS:
            self._last, self._changed_ns = {}, {}
        for message in tick.messages:
            if message.camera not in self._cameras:
                known = list(self._cameras)
                raise ValueError(f'camera is {message.camera!r}, expected one of {known}')
            new, old = message.rows.foreground, self._last.get(message.camera)
            self._last[message.camera] = new
            if old is None or not len(new) or not np.array_equal(old.mask, new.mask):
                self._changed_ns[message.camera] = new.stamp_ns

    def _left_out(self, stamp_ns: int) -> dict[str, Unusable]:
        """Tell whose masks are worth nothing, and why."""
        left_out = {}
        for camera in self._cameras:
            last = self._last.get(camera)
            if last is None or stamp_ns - last.stamp_ns > OLDEST_NS:
                left_out[camera] = Unusable.SILENT
            elif not last.mask.size:
                left_out[camera] = Unusable.UNKNOWN
            elif len(last) > MOST_FOREGROUND * last.mask.size:
                left_out[camera] = Unusable.DAZZLED
            elif stamp_ns - self._changed_ns[camera] > FROZEN_NS:
                left_out[camera] = Unusable.FROZEN
        return left_out

    def _explain(self, used: NDArray[np.bool_], stamp_ns: int) -> Occupancy:
        """Return the people that explain the masks, given where they were."""
        none = Foreground.build(stamp_ns)
        masks = tuple(self._last.get(camera, none).mask for camera in self._cameras)
        shapes = tuple((mask.shape[0], mask.shape[1]) for mask in masks)
        position = self._scene.position
        prior = np.zeros(len(position))
        known = self._joint.feedback()
        seconds = (stamp_ns - known.stamp_ns) * 1e-9
        if seconds < 0.0:  # time begins anew
            known = Feedback.build(stamp_ns)
        for place in known.position[:, :2] + seconds * known.velocity:
            squared = ((position - place) ** 2).sum(axis=1) / PRIOR_SIGMA_M**2
            np.maximum(prior, PRIOR_GAIN * np.exp(-squared / 2), out=prior)
        return solve(masks, self._scene.boxes(shapes), position, prior, used, self._cost)

    def _detections(self, people: Occupancy, tick: RowsTick[Sighting]) -> Detections:
        """Return people as detections of all cameras together, with the colours that these saw."""
        count = len(people.cell)
        place = np.column_stack([people.mean, np.zeros(count)])
        columns = Detections.build(tick.stamp_ns, position=place)
        template, extent = columns.template.copy(), columns.extent.copy()
        told = [message.rows.detections for message in tick.messages]
        seen = Detections.joined(tick.stamp_ns, told)
        seen = seen.select((seen.member_count == 1) & seen.template.any(axis=1))
        if count and len(seen):
            distance = np.linalg.norm(seen.position[:, None, :2] - people.mean, axis=2)
            nearest = np.nan_to_num(distance, nan=np.inf).argmin(axis=1)
            near = distance[np.arange(len(seen)), nearest] < NEAR_M
            for person in set(nearest[near].tolist()):
                own = near & (nearest == person)
                template[person] = seen.template[own].mean(axis=0)
                extent[person] = seen.extent[own].mean(axis=0)
        within_cell = np.eye(2) * self._scene.step**2 / 12  # of a place anywhere in its cell
        return columns.replace(
            covariance=people.covariance + within_cell,
            local_id=np.arange(1, count + 1),
            template=template,
            extent=extent,
        )

    def _seen_by(self, tracks: Tracks, people: Occupancy) -> Tracks:
        """Return tracks with the bits of the cameras in which they are seen."""
        if not len(tracks) or not len(people.cell):
            return tracks
        bits = np.left_shift(np.uint32(1), np.arange(len(self._cameras), dtype=np.uint32))
        with np.errstate(invalid='ignore'):
            seen = ((people.support >= LEAST_SUPPORT) * bits).sum(axis=1, dtype=np.uint32)
        distance = np.linalg.norm(tracks.position[:, None, :2] - people.mean, axis=2)
        cameras = np.where(tracks.cameras > 0, seen[distance.argmin(axis=1)], np.uint32(0))
        return tracks.replace(cameras=cameras)
