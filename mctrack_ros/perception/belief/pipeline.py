"""One camera of belief propagation: image and messages in, particles and detections out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import GroundMapping, ProjectiveMapping
from mctrack_ros.interfaces import Belief, Detections, Events
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters, boxes_of
from mctrack_ros.perception.camera_shift.monitor import CameraShift, ShiftState
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.pipeline import EventTracker
from mctrack_ros.perception.front_end import FrontEnd
from mctrack_ros.perception.moving_camera.moving_camera import CameraMotion, MovingCamera
from mctrack_ros.perception.output import CameraOutput

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

MESSAGES = (Detections, Belief)
"""Message types published for each image."""
KEPT_NS = 2_000_000_000
"""For how long it is kept how a moving camera looked, ns: feedback is newer."""


class BeliefCamera:
    """
    The view filters of a camera, and the event tracker that detects people to start with.

    Parameters
    ----------
    config : BeliefCameraConfig
        Parameters.
    name : str
        Of the camera: keys its random numbers.
    mapping : GroundMapping
        Of the camera; fixes the size of its images.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored, by the detector.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.
    lines : sequence of (n, 2) arrays
        Painted on the ground, m: a camera that moves is pulled back to them.

    Raises
    ------
    ConfigError
        If the camera moves and its calibration is no pinhole of known pose.

    """

    def __init__(
        self,
        config: BeliefCameraConfig,
        name: str,
        mapping: GroundMapping,
        mask: Image | None = None,
        background: Image | None = None,
        lines: Sequence[Floats] = (),
    ) -> None:
        self._detector: EventTracker | None = None
        self._moving: MovingCamera | None = None
        if config.moving:
            if not isinstance(mapping, ProjectiveMapping):
                raise ConfigError(
                    'pipeline.moving: the calibration has a lens or no pose, expected a pinhole '
                    'camera of the first image'
                )
            self._moving = MovingCamera(mapping, lines)
        else:
            detector = EventTrackerConfig(
                background=config.background, camera_shift=config.camera_shift
            )
            self._detector = EventTracker(detector, mapping, mask, background)
        self._front = FrontEnd(mapping, config.camera_shift, mask)
        self._filters = ViewFilters(mapping, name, config)
        self._box: Floats = np.zeros((0, 4))
        self._looked: dict[int, Floats] = {}

    def step(self, image: Image, stamp_ns: int, feedback: Belief | None) -> CameraOutput:
        """
        Process one image.

        A camera that is dark, has been moved, is lost while it moves or is not settled says
        nothing of targets.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image of the mapping's size.
        stamp_ns : int
            Its capture time, ns.
        feedback : Belief or None
            What fusion sent back, `feedback_delay` old.

        Raises
        ------
        BackwardStampError
            If the stamp is at or up to a second before the last one; nothing is changed.
        ValueError
            If the image has another size or type; nothing is changed.

        """
        if self._detector is not None:
            found = self._detector.step(image, stamp_ns, None)
            sees = found.is_settled and found.shift.state is not ShiftState.MOVED
        else:
            sees = self._front.take(image, stamp_ns) is not None
            detections = {Detections.TOPIC: Detections.build(stamp_ns)}
            found = CameraOutput(detections, Events.build(stamp_ns), CameraShift(), sees)
        belief = Belief.build(stamp_ns)
        motion = None
        if sees and self._moving is not None:
            sees, motion = self._follow(self._moving, image, stamp_ns, feedback)
        if sees:
            belief = self._filters.step(image, stamp_ns, feedback, motion)
        self._box = _mean_boxes(belief)
        messages = {
            Detections.TOPIC: found.messages[Detections.TOPIC],
            Belief.TOPIC: belief,
        }
        return CameraOutput(messages, found.events, found.shift, found.is_settled)

    def _follow(
        self, moving: MovingCamera, image: Image, stamp_ns: int, feedback: Belief | None
    ) -> tuple[bool, Floats | None]:
        """
        Follow the camera, where nobody is expected.

        Returns
        -------
        is_known : bool
            Whether it is known how it looks.
        motion : (3, 3) array or None
            Homography from its image at the feedback to this one.

        """
        view = moving.step(image, self._box)
        if view.state is CameraMotion.LOST:
            return False, None
        now = view.mapping.image_from_ground_homography
        self._filters.mapping = view.mapping
        self._looked = {
            stamp: each for stamp, each in self._looked.items() if stamp > stamp_ns - KEPT_NS
        }
        self._looked[stamp_ns] = now
        if feedback is None:
            return True, None
        nearest = min(self._looked, key=lambda stamp: abs(stamp - feedback.stamp_ns))
        return True, now @ np.linalg.inv(self._looked[nearest])

    def predicted_boxes(self) -> Floats:
        """Return the (n, 4) boxes, px, where targets are predicted, for an overlay."""
        return self._box

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""
        return [] if self._detector is None else self._detector.groups()


def _mean_boxes(belief: Belief) -> Floats:
    box = boxes_of(belief.image_state.astype(np.float64))
    means = [box[belief.track_id == target].mean(axis=0) for target in np.unique(belief.track_id)]
    return np.array(means).reshape(-1, 4)
