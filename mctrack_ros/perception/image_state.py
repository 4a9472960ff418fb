"""Whether an image shows anything: black, white, frozen and all-noise ones do not."""

from __future__ import annotations

from enum import StrEnum

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_3D, compiled

Image = NDArray[np.uint8]
SAMPLED_PX = 16  # every sixteenth pixel of a row and column tells a blank or frozen image
BLACK, WHITE = 8.0, 247.0  # mean grey levels
FROZEN_NS = 1_000_000_000  # an image that stays the same so long: noise changes a live one
NOISE = 30.0  # mean difference of neighbours, grey levels; images of scenes have 2 to 8


class ImageState(StrEnum):
    """What is wrong with a camera's images."""

    USABLE = 'usable'
    BLANK = 'blank'
    FROZEN = 'frozen'
    NOISE = 'noise'


def is_blank(image: Image) -> bool:
    """Tell whether a (h, w, 3) uint8 image is black or white all over."""
    return _is_blank(np.ascontiguousarray(image))


class ImageWatch:
    """Looks at images one after another, at a few of their pixels."""

    def __init__(self) -> None:
        self._last: Image = np.zeros((0, 0, 3), np.uint8)
        self._since_ns = 0

    def look(self, image: Image, stamp_ns: int) -> ImageState:
        """
        Return the state of the images.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The newest image.
        stamp_ns : int
            Its time, ns.

        """
        sample = image[::SAMPLED_PX, ::SAMPLED_PX].copy()
        if not np.array_equal(sample, self._last):
            self._last, self._since_ns = sample, stamp_ns
        if is_blank(image):
            return ImageState.BLANK
        if stamp_ns - self._since_ns >= FROZEN_NS:
            return ImageState.FROZEN
        right = image[::SAMPLED_PX, 1::SAMPLED_PX]
        beside = cv2.absdiff(sample[:, : right.shape[1]], np.ascontiguousarray(right))
        is_noise = max(cv2.mean(beside)[:3]) > NOISE
        return ImageState.NOISE if is_noise else ImageState.USABLE


@compiled(types.b1(BYTES_3D))
def _is_blank(image: Image) -> bool:
    """Look at a sample of the rows until it is plain that a channel is neither black nor white."""
    height, width = image.shape[:2]
    samples = len(range(0, height, SAMPLED_PX)) * len(range(0, width, SAMPLED_PX))
    bright, dark = np.zeros(3), np.zeros(3)
    for y in range(0, height, SAMPLED_PX):
        for x in range(0, width, SAMPLED_PX):
            for channel in range(3):
                bright[channel] += image[y, x, channel]
                dark[channel] += 255 - image[y, x, channel]
        brightest, darkest = max(bright[0], bright[1], bright[2]), max(dark[0], dark[1], dark[2])
        if brightest >= BLACK * samples and darkest >= (255 - WHITE) * samples:
            return False
    return True
