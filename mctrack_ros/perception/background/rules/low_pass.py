"""The silhouettes paper's low-pass filter."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.background.rules.rule import BackgroundUpdate, Image


def low_pass(
    level: NDArray[np.float32],
    image: Image,
    where: Image,
    seconds: float,
    beta: float,
    period_s: float,
) -> None:
    """
    Let a background learn: ``B += beta (I - B)`` (silhouettes paper, eq. (2)).

    The share is that of the time between two images, so the filter is the same at every rate.

    Parameters
    ----------
    level : (h, w) or (h, w, 3) float32 array
        The background; changed in place.
    image : uint8 array of the same shape
        An image.
    where : (h, w) uint8 array
        0 where nothing is learned.
    seconds : float
        Time since the last image, s.
    beta, period_s : float
        Share of a difference that is learned in one period, and that, s.

    """
    share = float(1 - (1 - beta) ** (seconds / period_s))
    cv2.accumulateWeighted(image, level, share, where)


class LowPassRule:
    """
    The filter as a `Rule`; foreground is not learned at all.

    Parameters
    ----------
    beta, period_s : float
        As `low_pass` has them.

    """

    def __init__(self, beta: float, period_s: float) -> None:
        self._beta, self._period_s = beta, period_s

    def begin(self, model: Image) -> None:
        """Start from an image; see `Rule`."""
        self._level = model.astype(np.float32)

    def foreground(self, image: Image) -> Image | None:
        """Have no test of its own."""
        return None

    def learn(self, model: Image, lesson: BackgroundUpdate) -> None:
        """Learn the background of an image; see `Rule`."""
        where = np.asarray(cv2.bitwise_not(lesson.mask), np.uint8)
        low_pass(self._level, lesson.image, where, lesson.seconds, self._beta, self._period_s)
        cv2.convertScaleAbs(self._level, model)

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Do nothing between lessons."""

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Take over what was made brighter."""
        self.accept(model)

    def accept(self, model: Image) -> None:
        """Take over a model that was changed from outside, where it was."""
        np.copyto(self._level, model, where=np.rint(self._level) != model)
