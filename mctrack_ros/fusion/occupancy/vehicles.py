"""Vehicles by the cameras' masks, people by their detections."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.occupancy.config import VehicleConfig
from mctrack_ros.fusion.occupancy.pipeline import OccupancyTracker
from mctrack_ros.fusion.occupancy.vehicle_scene import VehicleScene
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.views import OpenViews
from mctrack_ros.interfaces import (
    CameraRows,
    ClassCode,
    Detections,
    Events,
    Feedback,
    Foreground,
    RowsTick,
    Tracks,
)

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

VEHICLE_COST = 0.05
"""Share of the masks that a vehicle must explain, over all cameras: as a person."""
MARGIN_M = 0.4
"""Around a vehicle, m: its shadow, and that the true one is longer."""
MASK_PX = 160
"""Columns of the masks by which vehicles are looked for, about: they are large."""
MOST_COVERED = 0.5
"""A detection is a part of a vehicle if it stands where that does, or if this covers more of its
box, and its feet."""


class VehicleTracker:
    """
    Tracks vehicles by the masks of all cameras together, and people by their detections.

    A vehicle alone in one image is told from people by its size; where several cover each other,
    or are as grey as the ground, their blobs are cut into people. Here vehicles are found as
    `OccupancyTracker` finds people. What they cover of a camera's image is no person; of all
    else `JointTracker` makes people.

    Parameters
    ----------
    config : VehicleConfig
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
        If that is not known, or no camera sees ground.
    ValueError
        If there are too many cameras or a name occurs twice.

    """

    def __init__(
        self, config: VehicleConfig, cameras: tuple[str, ...], first_id: int, views: OpenViews
    ) -> None:
        seen = views()
        self._scene = VehicleScene(seen, cameras)
        self._vehicles = OccupancyTracker(config, cameras, first_id, self._scene, VEHICLE_COST)
        self._people = JointTracker(config, cameras, first_id)
        self._size = {name: seen.mappings[name].image_size for name in cameras}

    @property
    def bias(self) -> CameraBias:
        """How the cameras disagree about people."""
        return self._people.bias

    @property
    def next_id(self) -> int:
        """Id of the next track that begins."""
        return self._people.next_id

    @next_id.setter
    def next_id(self, next_id: int) -> None:
        self._people.next_id = self._vehicles.next_id = next_id

    def step(
        self, tick: RowsTick[OccupancyInput], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """Process one tick; see `JointTracker.step`. The recorder is told of people alone."""
        small = tuple(replace(each, rows=_reduced(each.rows)) for each in tick.messages)
        vehicles = self._vehicles.step(replace(tick, messages=small))
        people = tuple(
            CameraRows(each.camera, self._people_of(each.camera, each.rows.detections))
            for each in tick.messages
        )
        self._people.next_id = self._vehicles.next_id
        output = self._people.step(RowsTick(tick.stamp_ns, people, tick.record), recorder)
        self._vehicles.next_id = self._people.next_id
        tracks = Tracks.joined(tick.stamp_ns, [output.tracks, vehicles.tracks])
        events = Events.joined(tick.stamp_ns, [output.events, vehicles.events])
        order = np.lexsort((events.track_id, events.event))
        return FusionOutput(
            tracks.select(np.argsort(tracks.track_id, kind='stable')),
            events.select(order),
            vehicles.left_out,
            output.gates,
        )

    def feedback(self) -> Feedback:
        """Return the feedback after the last tick: a prediction of every target."""
        parts = [self._people.feedback(), self._vehicles.feedback()]
        joined = Feedback.joined(parts[0].stamp_ns, parts)
        return joined.select(np.argsort(joined.track_id, kind='stable'))

    def _people_of(self, camera: str, detections: Detections) -> Detections:
        """Return the detections of a camera that are no vehicles nor parts of them."""
        detections = detections.select(detections.class_id != ClassCode.VEHICLE)
        found = self._vehicles.found.cell
        if not len(detections) or not len(found):
            return detections
        columns, rows = self._size[camera]
        covered = np.zeros((rows, columns), np.uint8)
        for corners in self._scene.corners(camera, found, MARGIN_M):
            if np.isfinite(corners).all():
                cv2.fillConvexPoly(covered, cv2.convexHull(np.rint(corners).astype(np.int32)), 1)
        inside = self._scene.holds(found, detections.position[:, :2].astype(float), MARGIN_M)
        return detections.select(~(inside | _are_parts(detections.box, covered)))


def _reduced(both: OccupancyInput) -> OccupancyInput:
    """Return both with a mask of `MASK_PX` columns at most, of about the same foreground."""
    foreground = both.foreground
    times = max(1, round(foreground.mask.shape[1] / MASK_PX))
    if times == 1:
        return both
    height, width = (max(1, side // times) for side in foreground.mask.shape)
    mask = cv2.resize(foreground.mask, (width, height), interpolation=cv2.INTER_AREA)
    mask = np.asarray(mask > 127, np.uint8) * np.uint8(255)
    return OccupancyInput(both.detections, Foreground(foreground.stamp_ns, mask))


def _are_parts(box: NDArray[np.float32], covered: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Tell which boxes, (n, 4) px, are parts of what is covered in an image."""
    rows, columns = covered.shape
    total = cv2.integral(covered)
    corner = np.column_stack([box[:, :2], box[:, :2] + box[:, 2:]])
    edge = np.array([columns, rows] * 2)
    left, top, right, bottom = np.clip(np.rint(corner), 0, edge).astype(int).T
    inside = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
    foot = covered[np.maximum(bottom - 1, 0), np.minimum((left + right) // 2, columns - 1)] > 0
    return np.asarray(foot & (inside > MOST_COVERED * (right - left) * (bottom - top)))
