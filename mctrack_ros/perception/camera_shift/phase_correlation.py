"""Large shifts of a whole image, by phase correlation of reduced images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.uint8]
Floats32 = NDArray[np.float32]

WIDTH_PX = 192  # of the reduced image
CANDIDATES = 6  # peaks that patches try
LOCAL_PX = 8  # standard deviation of the surroundings that are taken off
DARK = 10.0  # grey levels, of noise rather than light
BAND = 0.15  # cycles a pixel
AROUND_PX = 2  # cleared on each side of a peak before the next is sought


def reduced(grey: Grey) -> Floats32:
    """Return the logarithm of an image, reduced and less its surroundings: light cancels."""
    height = max(round(WIDTH_PX * grey.shape[0] / grey.shape[1]), 1)
    small = cv2.resize(grey, (WIDTH_PX, height), interpolation=cv2.INTER_AREA)
    light = np.log(small.astype(np.float32) + np.float32(DARK))
    return np.asarray(light - cv2.GaussianBlur(light, (0, 0), LOCAL_PX), np.float32)


def coarse_shifts(image: Floats32, reference: Floats32) -> list[tuple[int, int]]:
    """
    Return the likeliest shifts of an image, px to the right and down, the likeliest first.

    A crowd gives the correlation (Kuglin and Hines 1975) peaks of its own, so that the highest
    need not be the image's.

    Parameters
    ----------
    image, reference : (h, w) float32 array
        From `reduced`.

    """
    height, width = reference.shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    cross = np.fft.rfft2(image * window) * np.conj(np.fft.rfft2(reference * window))
    cross /= np.abs(cross) + 1e-3 * np.abs(cross).mean() + 1e-12
    down, right = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)
    response = np.fft.irfft2(
        cross * np.exp(-(down**2 + right**2) / (2 * BAND**2)), s=(height, width)
    )
    shifts = []
    around = np.arange(-AROUND_PX, AROUND_PX + 1)
    for _ in range(CANDIDATES):
        y, x = divmod(int(response.argmax()), width)
        shifts.append(
            ((x + width // 2) % width - width // 2, (y + height // 2) % height - height // 2)
        )
        response[np.ix_((y + around) % height, (x + around) % width)] = -np.inf
    return shifts
