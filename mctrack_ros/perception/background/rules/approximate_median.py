"""The approximate median: recursive, in steps of one grey level."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, compiled
from mctrack_ros.perception.background.rules.illumination import relit
from mctrack_ros.perception.background.rules.ranks import (
    SAMPLES,
    WINDOW_PX,
    median_of_nine,
    smoother,
)
from mctrack_ros.perception.background.rules.rule import BackgroundUpdate, Image

IMAGE = types.Array(types.u1, 3, 'C')
BANDS = 16
FOREGROUND_SLOWDOWN = 10
"""Of so many lessons one moves foreground; by trial on simulated matches, as the next."""
TRACKED_SLOWDOWN = 100
"""Of so many lessons one moves what is tracked."""


@compiled(types.void(IMAGE, BYTES_3D, BYTES_2D))
def approach(model: Image, image: Image, kept: Image) -> None:
    """
    Move every pixel of a model by one grey level towards an image.

    Parameters
    ----------
    model, image : (h, w, 3) uint8 array
        The model, changed in place, and the image.
    kept : (h, w) uint8 array
        Not 0 where the model stays as it is.

    """
    old, new, stays = model.reshape(-1), image.reshape(-1), kept.reshape(-1)
    for index in range(len(stays)):  # flat: so the compiler makes vectors of it
        moves = np.uint8(stays[index] == 0)
        for channel in range(3):
            place = 3 * index + channel
            up, down = np.uint8(new[place] > old[place]), np.uint8(new[place] < old[place])
            old[place] = np.uint8(old[place] + np.uint8(up & moves) - np.uint8(down & moves))


class ApproximateMedian:
    """
    Each lesson moves every pixel of the model one grey level to the image.

    Foreground moves in one lesson of some, tracked foreground in one of many. Medians of nine
    images over longer times correct the model where they are smoother, so who stood still at
    the start leaves no hole (event-tracking paper, sections 3.1 and 4.2).

    Parameters
    ----------
    length_s, longest_s : float
        Time over which the first such median is taken, s, and the longest.

    """

    def __init__(self, length_s: float, longest_s: float) -> None:
        self._length_s, self._longest_s = length_s, max(length_s, longest_s)
        self._samples: list[Image] = []
        self._gain: list[NDArray[np.float64]] = []
        self._band = self._lessons = 0
        self._next_ns: int | None = None

    def begin(self, model: Image) -> None:
        """Have nothing to begin with: the model is all there is."""

    def foreground(self, image: Image) -> Image | None:
        """Have no test of its own."""
        return None

    def learn(self, model: Image, lesson: BackgroundUpdate) -> None:
        """Move the model; see `Rule`."""
        self._lessons += 1
        kept = lesson.mask
        if self._lessons % TRACKED_SLOWDOWN == 0:
            kept = np.zeros_like(lesson.mask)
        elif self._lessons % FOREGROUND_SLOWDOWN == 0:
            kept = lesson.tracked_mask()
        approach(model, lesson.image, kept)

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Collect nine images, evenly in time, and take their median; then nine more."""
        if len(self._samples) == SAMPLES:
            self._renew_band(model)
        elif self._next_ns is None or stamp_ns >= self._next_ns:
            self._samples.append(image.copy())
            self._gain.append(np.ones(3))
            self._next_ns = stamp_ns + round(self._length_s / SAMPLES * 1e9)

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Remember that what was collected is of another light."""
        self._gain = [before * gain for before in self._gain]

    def accept(self, model: Image) -> None:
        """Have nothing to take over: the model is all there is."""

    def _renew_band(self, model: Image) -> None:
        """Renew one band of the model: all at once would make this image late."""
        height, halo = len(model), WINDOW_PX
        top, bottom = (height * band // BANDS for band in (self._band, self._band + 1))
        low, high = max(top - halo, 0), min(bottom + halo, height)
        median = median_of_nine(
            [relit(one[low:high], gain) for one, gain in zip(self._samples, self._gain)]
        )
        chosen = smoother(model[low:high], median)
        model[top:bottom] = chosen[top - low : bottom - low]
        self._band += 1
        if self._band == BANDS:
            self._samples, self._gain, self._band = [], [], 0
            self._length_s = min(3 * self._length_s, self._longest_s)
