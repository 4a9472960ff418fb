"""Approximate-median background: what the picture looks like without moving objects."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter

Image = NDArray[np.uint8]
SAMPLES = 9
MEDIAN_OF_LARGEST = 1.26  # median of the largest of three |N(0, 1)|
NOISE_SHARE = 0.05
# Compare-exchange network whose middle element is the median of nine (Smith 1996).
MEDIAN_OF_NINE = (
    (1, 2), (4, 5), (7, 8), (0, 1), (3, 4), (6, 7), (1, 2), (4, 5), (7, 8), (0, 3),
    (5, 8), (4, 7), (3, 6), (1, 4), (2, 5), (4, 7), (4, 2), (6, 4), (4, 2),
)  # fmt: skip


@dataclass(frozen=True)
class BackgroundConfig:
    """Parameters of `MedianBackground`."""

    learning_s: float = parameter(
        0.8, 'length of the first samples; nothing is seen before they end [s]', minimum=0.0
    )
    refinement_s: float = parameter(
        8.0, 'length of the samples that then replace the first background [s]', minimum=0.0
    )
    update_period_s: float = parameter(
        0.2, 'time between steps of one grey level towards the picture [s]', minimum=0.001
    )
    foreground_slowdown: int = parameter(
        10, 'of so many steps one reaches pixels that are foreground', minimum=1
    )
    threshold_sigmas: float = parameter(
        5.0, 'difference that is foreground, in standard deviations of the noise', minimum=1.0
    )
    minimum_threshold: float = parameter(
        14.0, 'difference that is foreground at least [grey levels]', minimum=1.0, maximum=255.0
    )
    relearn_fraction: float = parameter(
        0.6, 'changed share of the picture from which the background is learned anew',
        minimum=0.05, maximum=1.0,
    )  # fmt: skip


def median_of_nine(images: list[Image]) -> Image:
    """Return the pixel-wise median of nine pictures."""
    work: list[Image] = list(images)
    for low, high in MEDIAN_OF_NINE:
        smaller, larger = cv2.min(work[low], work[high]), cv2.max(work[low], work[high])
        work[low], work[high] = smaller, larger  # type: ignore[assignment]
    return work[4]


class MedianBackground:
    """
    Approximate median: each step moves every pixel of the model one grey level to the picture.

    A first model is the median of nine pictures, a second one, over a longer time, replaces it:
    who stood still at the start leaves no hole. Foreground pixels move more slowly. The threshold
    follows the noise that is measured in the background (event-tracking paper, sections 3.1, 4.2;
    equation (1) with the largest of the three channels' differences).
    """

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Forget everything and learn anew."""
        self.model: Image | None = None
        self.noise: float | None = None
        self._samples: list[Image] = []
        self._next_sample_ns: int | None = None
        self._next_update_ns = 0
        self._updates = 0
        self._refined = False

    @property
    def threshold(self) -> float:
        """Difference from which a pixel is foreground, grey levels."""
        noise = self._config.threshold_sigmas * (self.noise or 0.0)
        return max(self._config.minimum_threshold, noise)

    def apply(self, image: Image, stamp_ns: int) -> Image | None:
        """
        Learn from a picture and tell what in it is foreground.

        Parameters
        ----------
        image : (height, width, 3) uint8 array
            The picture.
        stamp_ns : int
            Its time, ns; later than the last.

        Returns
        -------
        (height, width) uint8 array or None
            255 where the picture differs from the background; None while it is learned.

        """
        if not self._refined:
            self._sample(image, stamp_ns)
        if self.model is None:
            return None
        difference = cv2.absdiff(image, self.model)
        largest = cv2.max(
            cv2.max(cv2.extractChannel(difference, 0), cv2.extractChannel(difference, 1)),
            cv2.extractChannel(difference, 2),
        )
        measured = float(np.median(largest[::16, ::16])) / MEDIAN_OF_LARGEST
        self.noise = measured if self.noise is None else self.noise
        _, mask = cv2.threshold(largest, self.threshold, 255, cv2.THRESH_BINARY)
        if cv2.countNonZero(mask) > self._config.relearn_fraction * mask.size:
            self.restart()
            return None
        self.noise += (measured - self.noise) * NOISE_SHARE
        if stamp_ns >= self._next_update_ns:
            self._update(image, mask)
            self._next_update_ns = stamp_ns + round(self._config.update_period_s * 1e9)
        return mask  # type: ignore[return-value]

    def _sample(self, image: Image, stamp_ns: int) -> None:
        """Collect nine pictures, evenly in time, and take their median."""
        length = self._config.learning_s if self.model is None else self._config.refinement_s
        if self._next_sample_ns is None:
            self._next_sample_ns = stamp_ns
        if stamp_ns < self._next_sample_ns:
            return
        self._samples.append(image.copy())
        self._next_sample_ns += round(length / (SAMPLES - 1) * 1e9)
        if len(self._samples) < SAMPLES:
            return
        self._refined = self.model is not None
        self.model = median_of_nine(self._samples)
        self._samples, self._next_sample_ns = [], None

    def _update(self, image: Image, mask: cv2.typing.MatLike) -> None:
        """Move the model one grey level; foreground only now and then."""
        assert self.model is not None
        one = np.ones_like(self.model)
        upper, lower = cv2.add(self.model, one), cv2.subtract(self.model, one)
        moved = cv2.max(lower, cv2.min(upper, image))
        self._updates += 1
        if self._updates % self._config.foreground_slowdown:
            cv2.copyTo(moved, cv2.bitwise_not(mask), self.model)
        else:
            self.model = moved.astype(np.uint8, copy=False)
