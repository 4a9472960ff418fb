"""Fusion of the cameras' masks: people who explain them all, tracked as the joint tracker does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.occupancy.masks import Masks, prior_of
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.occupancy.solver import Occupancy
from mctrack_ros.fusion.occupancy.vehicle_scene import VehicleScene
from mctrack_ros.interfaces import CameraRows, Detections, Feedback, RowsTick, Tracks

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]

ALL = 'all'
"""What the cameras together are called where decisions are explained."""
NEAR_M = 0.7
"""How near to a person the detection must be that tells his colours, m."""
LEAST_SUPPORT = 0.5
"""Share of a person's box that must be foreground in a camera that sees him."""


class OccupancyTracker:
    """
    Finds people, or vehicles, by the masks of all cameras together and tracks them.

    The likelihood-grid paper's last section asks for background subtraction as another layer of
    its grid. Here it is the only one: the set of people that explains all masks is one detection
    each for `JointTracker`.

    Parameters
    ----------
    config : JointConfig
        Parameters of tracking.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.
    scene : Scene or VehicleScene
        Where they can be.
    cost : float
        Share of the masks that each must explain, over all cameras.

    Attributes
    ----------
    found : Occupancy
        Who explains the masks of the last tick.

    Raises
    ------
    ConfigError
        If cameras are untrusted.
    ValueError
        If there are too many cameras or a name occurs twice.

    """

    bias = None

    def __init__(
        self,
        config: JointConfig,
        cameras: tuple[str, ...],
        first_id: int,
        scene: Scene | VehicleScene,
        cost: float,
    ) -> None:
        if config.untrusted:
            raise ConfigError(
                f'untrusted is {config.untrusted!r}, but tracker {config.tracker} starts tracks '
                'by the masks of all cameras together: leave it empty, or name joint'
            )
        self._cameras, self._scene = cameras, scene
        self._masks = Masks(cameras, scene, cost)
        self._joint = JointTracker(config, (ALL,), first_id)

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._joint.next_id

    @next_id.setter
    def next_id(self, next_id: int) -> None:
        self._joint.next_id = next_id

    def step(
        self, tick: RowsTick[OccupancyInput], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """
        Process one tick; see `JointTracker.step`.

        A camera without a new mask counts with its last one for `OLDEST_NS`; one whose mask is
        nearly all foreground, frozen or unknown does not count, which the output says.
        """
        received = [CameraRows(each.camera, each.rows.foreground) for each in tick.messages]
        self._masks.take(received, tick.stamp_ns)
        left_out = self._masks.left_out(tick.stamp_ns)
        known = self._joint.feedback()
        if known.stamp_ns > tick.stamp_ns:  # time begins anew
            known = Feedback.build(tick.stamp_ns)
        prior = prior_of(known.places(tick.stamp_ns), self._scene.position)
        people = self.found = self._masks.explained(left_out, prior, tick.stamp_ns)
        detections = self._detections(people, tick)
        joint = RowsTick(tick.stamp_ns, (CameraRows(ALL, detections),), tick.record)
        output = self._joint.step(joint, recorder)
        return replace(output, tracks=self._seen_by(output.tracks, people), left_out=left_out)

    def feedback(self) -> Feedback:
        """Return the feedback after the last tick: a prediction of every target."""
        return self._joint.feedback()

    def _detections(self, people: Occupancy, tick: RowsTick[OccupancyInput]) -> Detections:
        """Return people as detections of all cameras together, with the colours that these saw."""
        count = len(people.cell)
        place = np.column_stack([people.mean, np.zeros(count)])
        columns = Detections.build(tick.stamp_ns, position=place)
        template, extent = columns.template.copy(), columns.extent.copy()
        extent[:] = self._scene.extent
        received = [message.rows.detections for message in tick.messages]
        seen = Detections.joined(tick.stamp_ns, received)
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
            class_id=np.full(count, self._scene.class_id),
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
