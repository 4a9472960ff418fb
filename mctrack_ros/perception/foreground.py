"""The foreground mask that a camera publishes, reduced until a person is about 22 px high."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.ground.plausible import PERSON_M
from mctrack_ros.interfaces import Foreground

Image = NDArray[np.uint8]
PERSON_PX = 22.0
"""Median height of persons in the reduced mask, px."""
NARROWEST_PX = 90
"""Least width of a reduced mask, px."""


class Reduction:
    """
    Reduces masks of a camera by a whole factor.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    scale : float
        Pixels of its images to one of the masks.

    """

    def __init__(self, mapping: GroundMapping, scale: float) -> None:
        width, _ = mapping.image_size
        usual = mapping.usual_height_px(PERSON_M) or PERSON_PX
        factor = min(usual / PERSON_PX, width / NARROWEST_PX) / scale
        self._factor = max(int(factor), 1)

    def foreground(self, mask: Image, stamp_ns: int) -> Foreground:
        """Return a mask, (h, w) with 255, reduced: a pixel is set if half of its pixels are."""
        height, width = mask.shape
        size = max(width // self._factor, 1), max(height // self._factor, 1)
        share = cv2.resize(mask, size, interpolation=cv2.INTER_AREA)
        _, reduced = cv2.threshold(share, 127, 255, cv2.THRESH_BINARY)
        return Foreground(stamp_ns, np.asarray(reduced, np.uint8))
