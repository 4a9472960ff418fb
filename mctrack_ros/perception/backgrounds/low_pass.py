"""The silhouettes paper's low-pass filter."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.backgrounds.rule import Image, Lesson


class LowPass:
    """
    A low-pass filter for each pixel: ``B += beta (I - B)`` (silhouettes paper, eq. (2)).

    The share is that of the time between two pictures, so the filter is the same at every rate.

    Parameters
    ----------
    beta : float
        Share of a difference that is learned in one period.
    period_s : float
        That period, s.
    model : (h, w) or (h, w, 3) uint8 array
        Picture to start from.

    Attributes
    ----------
    level : float32 array
        The background, of the picture's shape.

    """

    def __init__(self, beta: float, period_s: float, model: Image) -> None:
        self._beta, self._period_s = beta, period_s
        self.level: NDArray[np.float32] = model.astype(np.float32)

    def learn(self, image: Image, where: Image, seconds: float) -> None:
        """Learn from a picture, some seconds after the last, where a (h, w) mask is not 0."""
        share = 1 - (1 - self._beta) ** (seconds / self._period_s)
        cv2.accumulateWeighted(image, self.level, share, where)


class LowPassRule:
    """
    The filter as a `Rule`: foreground is not learned at all.

    Parameters
    ----------
    beta, period_s : float
        As `LowPass` has them.

    """

    def __init__(self, beta: float, period_s: float) -> None:
        self._beta, self._period_s = beta, period_s

    def begin(self, model: Image) -> None:
        """Start from a picture; see `Rule`."""
        self._filter = LowPass(self._beta, self._period_s, model)

    def foreground(self, image: Image) -> Image | None:
        """Have no test of its own."""
        return None

    def learn(self, model: Image, lesson: Lesson) -> None:
        """Learn the background of a picture; see `Rule`."""
        where = np.asarray(cv2.bitwise_not(lesson.mask), np.uint8)
        self._filter.learn(lesson.image, where, lesson.seconds)
        cv2.convertScaleAbs(self._filter.level, model)

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Do nothing between lessons."""

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Take over what was made brighter."""
        self.accept(model)

    def accept(self, model: Image) -> None:
        """Take over a model that was changed from outside, where it was."""
        level = self._filter.level
        np.copyto(level, model, where=np.rint(level) != model)
