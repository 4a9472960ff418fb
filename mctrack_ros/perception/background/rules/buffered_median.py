"""The median of a buffer of images: not recursive."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.background.rules.illumination import relit
from mctrack_ros.perception.background.rules.ranks import SAMPLES, median_of_nine
from mctrack_ros.perception.background.rules.rule import BackgroundUpdate, Image

BANDS = 16


class BufferedMedian:
    """
    The model is the median of the last nine images kept (event-tracking paper, section 3.1).

    What is tracked is kept as the model has it, so that it does not burn in. A mistake in one
    image is gone when the image is.

    Parameters
    ----------
    length_s : float
        Time between the first and the last of the nine, s.

    """

    def __init__(self, length_s: float) -> None:
        self._spacing_ns = round(length_s / (SAMPLES - 1) * 1e9)
        self._next_ns: int | None = None
        self._band = BANDS

    def begin(self, model: Image) -> None:
        """Start from an image; see `Rule`."""
        self._kept = deque([model.copy()] * SAMPLES, SAMPLES)

    def foreground(self, image: Image) -> Image | None:
        """Have no test of its own."""
        return None

    def learn(self, model: Image, lesson: BackgroundUpdate) -> None:
        """Keep an image, if it is time again; see `Rule`."""
        if self._next_ns is not None and lesson.stamp_ns < self._next_ns:
            return
        self._next_ns = lesson.stamp_ns + self._spacing_ns
        kept = lesson.image.copy()
        np.copyto(kept, model, where=lesson.tracked_mask()[..., None] > 0)
        self._kept.append(kept)
        self._band = 0

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Renew one band of the model: all at once would make this image late."""
        if self._band == BANDS:
            return
        top, bottom = (len(model) * band // BANDS for band in (self._band, self._band + 1))
        model[top:bottom] = median_of_nine([kept[top:bottom] for kept in self._kept])
        self._band += 1

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Make what is kept brighter, too."""
        self._kept = deque([relit(kept, gain) for kept in self._kept], SAMPLES)

    def accept(self, model: Image) -> None:
        """Begin anew with a model that was changed from outside."""
        self.begin(model)
