"""What every camera pipeline gives, and what it refuses to take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, Events, Message
from mctrack_ros.perception.camera_shift.monitor import CameraShift

Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class CameraOutput:
    """
    What one image gave.

    Attributes
    ----------
    messages : mapping of str to Message
        Messages of every image, by topic below the camera's; blind or empty while the
        background is learned.
    events : Events
        What happened to the camera's own tracks; ``others`` are local ids.
    shift : CameraShift
        Whether the camera has moved since the start, as far as is known.
    is_settled : bool
        Whether there is a background to compare images with; without, nobody is seen.

    """

    messages: Mapping[str, Message]
    events: Events
    shift: CameraShift
    is_settled: bool = True

    @classmethod
    def empty(
        cls, kinds: Iterable[type[Message]], stamp_ns: int, shift: CameraShift
    ) -> CameraOutput:
        """Return what is said while there is nothing to compare an image with."""
        messages = {
            kind.TOPIC: Detections.blind(stamp_ns) if kind is Detections else kind.build(stamp_ns)
            for kind in kinds
        }
        return cls(messages, Events.build(stamp_ns), shift, is_settled=False)

    @property
    def detections(self) -> Detections:
        """What is detected; none, if the tracker sends other messages."""
        found = self.messages.get(Detections.TOPIC)
        if isinstance(found, Detections) and not found.is_blind:
            return found
        return Detections.build(self.events.stamp_ns)


def check_image(image: Image, size: tuple[int, int]) -> None:
    """Refuse, by `ValueError`, what is no BGR image of a width and height."""
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ValueError(
            f'image has shape {image.shape} and type {image.dtype}, '
            'expected (height, width, 3) and uint8'
        )
    height, width = image.shape[:2]
    if (width, height) != tuple(size):
        raise ValueError(f'image is {width} x {height}, expected {size[0]} x {size[1]}')


def check_mask(mask: Image | None, size: tuple[int, int]) -> None:
    """Refuse, by `ValueError`, a mask of another than a width and height."""
    expected = size[::-1]
    if mask is not None and (mask.shape != expected or mask.dtype != np.uint8):
        raise ValueError(
            f'mask has shape {mask.shape} and type {mask.dtype}, expected {expected} and uint8'
        )
