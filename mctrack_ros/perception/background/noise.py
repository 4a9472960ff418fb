"""Noise that is not the same everywhere: which parts of the image have more than others."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
ROWS, COLUMNS = 6, 8
SAMPLED_PX = 4
LEAST_SAMPLES = 10
TIME_S = 4.0
MEDIAN_OF_LARGEST = 1.26  # median of the largest of three |N(0, 1)|
LEAST_RATIO, MOST_RATIO = 0.5, 4.0


class NoiseMap:
    """
    How much noisier than the whole image each of its parts is.

    Bright parts are (photons come at random), and corners that a lens darkens and the camera
    brightens, and foliage. The noise of the whole may leap, with the camera's gain; how it is
    spread changes slowly (event-tracking paper, section 3.2: what is believed of a measurement
    follows what is observed).

    Attributes
    ----------
    ratio : (6, 8) float64 array
        Noise of each part, the median of the whole being 1.

    """

    def __init__(self) -> None:
        self.ratio: Floats = np.ones((ROWS, COLUMNS))
        self._known_s: Floats = np.zeros((ROWS, COLUMNS))
        self._levels: Image = np.zeros((0, 0), np.uint8)
        self._levels_of: tuple[int, int] | None = None

    def learn(self, difference: Image, mask: Image, noise: float, seconds: float) -> None:
        """
        Look at what is not foreground.

        Parameters
        ----------
        difference : (h, w) uint8 array
            Of an image from the background.
        mask : (h, w) uint8 array
            Foreground, not 0.
        noise : float
            Standard deviation of a channel's noise, of the whole image, grey levels.
        seconds : float
            Since the last one, s.

        """
        if noise <= 0.0:
            return
        self._levels_of = None
        median, count = _medians(difference, mask)
        enough = count >= LEAST_SAMPLES
        measured = median / MEDIAN_OF_LARGEST / noise
        self._known_s[enough] = np.minimum(self._known_s[enough] + seconds, TIME_S)
        share = np.minimum(seconds / np.maximum(self._known_s, 1e-9), 1.0)
        change = np.where(enough, share * (measured - self.ratio), 0.0)
        self.ratio = np.clip(self.ratio + change, LEAST_RATIO, MOST_RATIO)

    def foreground(self, difference: Image, least: float, usual: float, mask: Image) -> int:
        """
        Write 255 where a difference is larger than the noise there explains, 0 elsewhere.

        What is larger is worked out again when something was learned or a bound has changed.

        Parameters
        ----------
        difference : (h, w) uint8 array
            Of an image from the background.
        least, usual : float
            What is not foreground anywhere, and where the noise is that of the whole.
        mask : (h, w) uint8 array
            Is overwritten.

        Returns
        -------
        int
            How many pixels are.

        """
        bounds = int(least), round(usual)
        if bounds != self._levels_of:
            self._levels_of = bounds
            level = np.minimum(np.maximum(usual * self.ratio, least), 255.0).astype(np.uint8)
            self._levels = np.asarray(cv2.resize(level, difference.shape[::-1]), np.uint8)
        return _above(difference, self._levels, mask)


@compiled(types.i8(BYTES_2D, BYTES_2D, types.Array(types.u1, 2, 'C')))
def _above(difference: Image, levels: Image, mask: Image) -> int:
    """Write where a difference is above its level, and count; the image is read only once."""
    found, level, out = difference.reshape(-1), levels.reshape(-1), mask.reshape(-1)
    count = 0
    for index in range(len(out)):  # flat: so the compiler makes vectors of it
        above = found[index] > level[index]
        out[index] = np.uint8(255) if above else np.uint8(0)
        count += above
    return count


@compiled(types.Tuple([types.f8[:, ::1], types.i8[:, ::1]])(BYTES_2D, BYTES_2D))
def _medians(difference: Image, mask: Image) -> tuple[Floats, NDArray[np.int64]]:
    """Return the median difference of each part's background, of grouped data, and its pixels."""
    histogram = np.zeros((ROWS, COLUMNS, 256), np.int64)
    count = np.zeros((ROWS, COLUMNS), np.int64)
    height, width = difference.shape
    for y in range(0, height, SAMPLED_PX):
        row = y * ROWS // height
        for x in range(0, width, SAMPLED_PX):
            if mask[y, x] == 0:
                histogram[row, x * COLUMNS // width, difference[y, x]] += 1
                count[row, x * COLUMNS // width] += 1
    median = np.zeros((ROWS, COLUMNS))
    for row in range(ROWS):
        for column in range(COLUMNS):
            below, half = 0, count[row, column] / 2
            for level in range(256):
                there = histogram[row, column, level]
                if there > 0 and below + there >= half:
                    median[row, column] = max(level - 0.5 + (half - below) / there, 0.0)
                    break
                below += there
    return median, count
