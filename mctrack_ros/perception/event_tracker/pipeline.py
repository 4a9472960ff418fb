"""One camera, one image after another: foreground, blobs, local tracks, detections."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.ground.plausible import PERSON_M
from mctrack_ros.interfaces import Detections, Feedback, Foreground, Message
from mctrack_ros.perception.background.objects import marked, objects_in
from mctrack_ros.perception.background.scene import Scene
from mctrack_ros.perception.blobs.extraction import Blobs, clean_mask, find_blobs
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.camera_shift.monitor import ShiftState
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.tracker import LocalTracker
from mctrack_ros.perception.foreground import Reduction
from mctrack_ros.perception.front_end import Arrival, FrontEnd
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.output import CameraOutput, check_image
from mctrack_ros.tracking.appearance import balance_of

Image = NDArray[np.uint8]
MESSAGES = (Detections, Foreground)
"""Message types published for each image."""


class EventTracker:
    """
    Image and feedback in, detections and events out (event-tracking paper, section 4.2).

    Parameters
    ----------
    config : EventTrackerConfig
        Parameters.
    mapping : GroundMapping
        Of the camera; fixes the size of its images.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.

    Raises
    ------
    ValueError
        If the mask or the background has another size than the mapping's images.

    """

    def __init__(
        self,
        config: EventTrackerConfig,
        mapping: GroundMapping,
        mask: Image | None = None,
        background: Image | None = None,
    ) -> None:
        least_px = config.limits.farthest_px(mapping)
        config = replace(config, blobs=replace(config.blobs, farthest_height_px=least_px))
        self._config, self._mapping = config, mapping
        self._front = FrontEnd(mapping, config.camera_shift, mask)
        self._sizes = SizeTable(mapping)
        if background is not None:
            check_image(background, mapping.image_size)
        given = [None if one is None else self._reduced(one) for one in (mask, background)]
        scale = float(config.reduction)
        self._scene = Scene(config.background, config.shadows, mapping, scale, *given)
        self._reduction = Reduction(mapping, config.reduction)
        self._upright = _upright(mapping, config.reduction)
        self._tracker = LocalTracker(config, mapping, self._sizes)

    def step(self, image: Image, stamp_ns: int, feedback: Feedback | None) -> CameraOutput:
        """
        Process one image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image of the mapping's size. One that is black or white counts as none.
        stamp_ns : int
            Its capture time, ns. A gap or a step back of more than a second restarts the local
            tracks, unless the camera is as slow as that; local ids go on.
        feedback : Feedback or None
            The fusion node's, `feedback_delay` old; see `FeedbackBuffer`.

        Raises
        ------
        BackwardStampError
            If the stamp is at or up to a second before the last one; nothing is changed.
        ValueError
            If the image has another size or type; nothing is changed.

        """
        arrival = self._front.take(image, stamp_ns)
        if arrival is None:
            return CameraOutput.empty(MESSAGES, stamp_ns, self._front.shift)
        self._begin_anew(arrival)
        frame = self._foreground(image, stamp_ns)  # background subtracted, shadows taken out
        if frame is None:
            self._tracker.restart()
            return CameraOutput.empty(MESSAGES, stamp_ns, arrival.shift)
        blobs = self._blobs(frame)  # connected foreground that is not only shadow
        noise_px = arrival.shift.noise_px
        detections, events = self._tracker.step(blobs, frame, stamp_ns, feedback, noise_px)
        self._learn(frame, detections, stamp_ns)  # where nobody is
        foreground = Foreground.build(stamp_ns)
        if arrival.shift.state is not ShiftState.MOVED:
            foreground = self._reduction.foreground(frame.objects, stamp_ns)
        messages: dict[str, Message] = {Detections.TOPIC: detections, Foreground.TOPIC: foreground}
        return CameraOutput(messages, events, arrival.shift)

    def predicted_boxes(self) -> NDArray[np.float64]:
        """Return the (n, 4) boxes, px, where the last image was to show its tracks."""
        return self._tracker.predicted_box

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""
        return self._tracker.groups()

    def _begin_anew(self, arrival: Arrival) -> None:
        """Begin anew where time has jumped."""
        if arrival.jumped:
            self._tracker.restart()
        if arrival.stepped_back:
            self._scene.begin_anew()

    def _foreground(self, image: Image, stamp_ns: int) -> Frame | None:
        """Return an image with its foreground; None: the background is still learned."""
        small, scene = self._reduced(image), self._scene.background
        found = self._scene.foreground(small, stamp_ns)
        background, difference = scene.model, scene.difference
        if found is None or background is None:
            return None
        mask = clean_mask(found, difference, scene.threshold, self._config.blobs)
        objects = objects_in(small, background, mask)
        cv2.bitwise_and(mask, cv2.dilate(objects, self._upright), mask)  # without their shadows
        scale = float(self._config.reduction)
        balance = balance_of(background)
        return Frame(small, found, mask, objects, background, difference, scale, balance)

    def _blobs(self, frame: Frame) -> Blobs:
        """Return the blobs of a frame, in pixels of the full image."""
        scale = frame.scale
        blobs = find_blobs(
            frame.mask, frame.difference, self._mapping, self._sizes, scale, self._config.blobs
        )
        shade = self._scene.shadows.alone(
            frame.image,
            frame.background,
            frame.mask,
            blobs.box / scale,
            blobs.area / scale**2,
            self._scene.noise,
        )
        return blobs.select(~shade) if shade.any() else blobs

    def _learn(self, frame: Frame, detections: Detections, stamp_ns: int) -> None:
        """Tell the background where the targets of fusion are, and which of them walked there."""
        seen = detections.track_id > 0
        walked = seen & np.isin(detections.local_id, self._tracker.walked_ids())
        boxes = [detections.box[which] / frame.scale for which in (seen, walked)]
        people, protected = (marked(box, frame.mask.shape) for box in boxes)
        self._scene.background.learn(frame.image, frame.objects, people, protected, stamp_ns)

    def _reduced(self, image: Image) -> Image:
        factor = self._config.reduction
        if factor == 1:
            return image
        height, width = image.shape[:2]
        size = (width // factor, height // factor)
        return cv2.resize(image, size, interpolation=cv2.INTER_AREA)  # type: ignore[return-value]


def _upright(mapping: GroundMapping, reduction: int) -> Image:
    """
    Return the kernel, (h, 1), that reaches half a usual person's height up and down.

    Foreground so near an object belongs to it, like grey legs; shade lies beside.
    """
    half = round(mapping.usual_height_px(PERSON_M) / reduction / 2)
    return np.ones((2 * half + 1, 1), np.uint8)
