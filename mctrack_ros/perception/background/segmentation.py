"""Otsu's threshold and the Laplacian of a Gaussian, as the event-tracking paper names them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SIGMA_PX = 1.4


def otsu_threshold(difference: Image, least: float) -> float:
    """
    Return the level that parts a difference into background and objects best (Otsu 1979).

    In an image without objects it would part the noise, so it has a least value.

    Parameters
    ----------
    difference : (h, w) uint8 array
        Of an image from the background.
    least : float
        Level below which it never lies, grey levels.

    """
    level, _ = cv2.threshold(difference, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return max(float(level), least)


def inside_edges(mask: Image, difference: Image) -> Image:
    """
    Return a mask without what lies outside the edges of its objects.

    The Laplacian of the smoothed difference changes its sign on an edge and is positive outside
    (event-tracking paper, section 3.1: it reduces noise in foreground pixels and along edges).

    Parameters
    ----------
    mask, difference : (h, w) uint8 array
        Foreground, 255, and the image's difference from the background.

    """
    smooth = cv2.GaussianBlur(difference, (0, 0), SIGMA_PX)
    outside = np.asarray(cv2.Laplacian(smooth, cv2.CV_16S)) > 0
    return np.where(outside, np.uint8(0), mask)
