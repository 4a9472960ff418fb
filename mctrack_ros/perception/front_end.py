"""What all camera trackers do with an image first: size, stamp, whether the camera has moved."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.camera_shift.monitor import (
    CameraShift,
    CameraShiftConfig,
    CameraShiftMonitor,
)
from mctrack_ros.perception.image_clock import ImageClock
from mctrack_ros.perception.image_state import is_blank
from mctrack_ros.perception.output import check_image, check_mask

Image = NDArray[np.uint8]


class Arrival(NamedTuple):
    """
    What is known of an image before it is looked at.

    Attributes
    ----------
    seconds : float
        Time since the image before, s; 0 at the first, and where time has jumped.
    jumped, stepped_back : bool
        Whether tracks begin anew, and whether backgrounds do too; see `ImageClock`.
    shift : CameraShift
        How far the camera has moved.

    """

    seconds: float
    jumped: bool
    stepped_back: bool
    shift: CameraShift


class FrontEnd:
    """
    Takes the images of a camera.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera; fixes the size of its images.
    config : CameraShiftConfig
        Of noticing that the camera has moved.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.

    Raises
    ------
    ValueError
        If the mask has another size than the mapping's images.

    """

    def __init__(
        self, mapping: GroundMapping, config: CameraShiftConfig, mask: Image | None
    ) -> None:
        check_mask(mask, mapping.image_size)
        self._image_size = mapping.image_size
        self._monitor = CameraShiftMonitor(config, mask)
        self._clock = ImageClock()

    @property
    def shift(self) -> CameraShift:
        """How far the camera had moved at the last image that showed anything."""
        return self._monitor.shift

    def take(self, image: Image, stamp_ns: int) -> Arrival | None:
        """
        Take an image; None: it is black or white and counts as none.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image of the mapping's size.
        stamp_ns : int
            Its capture time, ns.

        Raises
        ------
        BackwardStampError
            If the stamp is at or up to a second before the last one; nothing is changed.
        ValueError
            If the image has another size or type; nothing is changed.

        """
        check_image(image, self._image_size)
        if is_blank(image):
            self._clock.pass_over(stamp_ns)
            return None
        clock = self._clock
        clock.advance(stamp_ns)
        shift = self._monitor.watch(image, stamp_ns)
        return Arrival(clock.seconds, clock.jumped, clock.stepped_back, shift)
