"""One camera of belief propagation: image and messages in, particles and detections out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Belief, Detections, Events
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters, boxes_of
from mctrack_ros.perception.camera_shift.monitor import ShiftState
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.pipeline import EventTracker
from mctrack_ros.perception.front_end import FrontEnd
from mctrack_ros.perception.output import CameraOutput

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

MESSAGES = (Detections, Belief)
"""Message types published for each image."""


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

    """

    def __init__(
        self,
        config: BeliefCameraConfig,
        name: str,
        mapping: GroundMapping,
        mask: Image | None = None,
        background: Image | None = None,
    ) -> None:
        self._detector: EventTracker | None = None
        if config.detect:
            detector = EventTrackerConfig(background=config.background, watchdog=config.watchdog)
            self._detector = EventTracker(detector, mapping, mask, background)
        self._front = FrontEnd(mapping, config.watchdog, mask)
        self._filters = ViewFilters(mapping, name, config)
        self._box: Floats = np.zeros((0, 4))

    def step(self, image: Image, stamp_ns: int, feedback: Belief | None) -> CameraOutput:
        """
        Process one image.

        A camera that is dark, has moved or is not settled says nothing of targets.

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
            found = CameraOutput(detections, Events.build(stamp_ns), self._front.shift, sees)
        belief = Belief.build(stamp_ns)
        if sees:
            belief = self._filters.step(image, stamp_ns, feedback)
        self._box = _mean_boxes(belief)
        messages = {
            Detections.TOPIC: found.messages[Detections.TOPIC],
            Belief.TOPIC: belief,
        }
        return CameraOutput(messages, found.events, found.shift, found.is_settled)

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
