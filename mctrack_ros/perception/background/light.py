"""How much brighter an image is than another, and images made brighter."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled

Image = NDArray[np.uint8]
Gains = NDArray[np.float64]
SAMPLED_PX = 16
DARKEST, BRIGHTEST = 16, 250
"""Grey levels between which a pixel tells of the light: it is neither black nor saturated."""

LEAST_SAMPLES = 30
STEPS = 512
"""Into so many steps a factor of 1 is divided."""


class Light:
    """
    Follows the light on what stood still at the start, whatever the model has learned since.

    Attributes
    ----------
    level : (3,) float64 array
        How much brighter blue, green and red were than at the start, when last followed.

    Parameters
    ----------
    model : (h, w, 3) uint8 array
        The background at the start.

    """

    def __init__(self, model: Image) -> None:
        self._reference = samples(model)
        self.level: Gains = np.ones(3)

    def follow(self, image: Image, least: float = 0.0) -> Gains:
        """Return how the light has changed since it did so last by at least a share; else 1."""
        level = gains(samples(image), self._reference)
        change = level / self.level
        if not has_changed(change, least):
            return np.ones(3)
        self.level = level
        return np.asarray(change)


def has_changed(gain: Gains, least: float) -> bool:
    """Tell whether any of (3,) factors differs from 1 by at least a share."""
    return bool((np.abs(gain - 1) >= least).any())


def explains(gain: Gains, image: Image, model: Image) -> bool:
    """Tell whether, made brighter, an image is at least twice as like another as before."""
    new, old = samples(image).astype(np.float32), samples(model).astype(np.float32)
    after = np.median(np.abs(new - np.minimum(old * gain, 255.0)))
    return bool(2 * after <= np.median(np.abs(new - old)))


def samples(image: Image) -> Image:
    """Return every sixteenth pixel of every sixteenth row, (n, 3) uint8."""
    return image[SAMPLED_PX // 2 :: SAMPLED_PX, SAMPLED_PX // 2 :: SAMPLED_PX].reshape(-1, 3)


@compiled(types.f8[::1](BYTES_2D, BYTES_2D))
def gains(image: Image, model: Image) -> Gains:
    """
    Return by what factor each channel of one image is brighter than another's, the median.

    Parameters
    ----------
    image, model : (n, c) uint8 array
        The same pixels of both.

    Returns
    -------
    (c,) float64 array
        To 1 / `STEPS`; 1 where too few pixels tell.

    """
    channels = image.shape[1]
    found = np.ones(channels)
    for channel in range(channels):
        histogram = np.zeros(STEPS * 256 // DARKEST, np.int64)
        count = 0
        for index in range(len(image)):
            new, old = int(image[index, channel]), int(model[index, channel])
            if DARKEST <= old < BRIGHTEST and 0 < new < BRIGHTEST:
                histogram[(2 * STEPS * new + old) // (2 * old)] += 1
                count += 1
        if count >= LEAST_SAMPLES:
            middle, passed = 0, histogram[0]
            while 2 * passed < count:
                middle += 1
                passed += histogram[middle]
            found[channel] = middle / STEPS
    return found


def relit(image: Image, gain: Gains) -> Image:
    """Return an image whose channels are brighter by (3,) factors, saturated at 255."""
    if (gain == 1.0).all():
        return image
    table = np.clip(np.rint(np.arange(256)[:, None] * gain), 0, 255).astype(np.uint8)
    return cv2.LUT(image, table[None])  # type: ignore[return-value]
