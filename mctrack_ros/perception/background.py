"""Approximate-median background: what the picture looks like without moving objects."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.difference import subtract

Image = NDArray[np.uint8]
SAMPLES = 9
BANDS = 16
MEDIAN_OF_LARGEST = 1.26  # median of the largest of three |N(0, 1)|
NOISE_SHARE = 0.05
KERNEL = np.ones((3, 3), np.uint8)
WINDOW_PX = 13  # about the width of a person
EDGE_MARGIN = 3.0  # grey levels
# Compare-exchange network whose middle element is the median of nine (Smith 1996).
MEDIAN_OF_NINE = (
    (1, 2), (4, 5), (7, 8), (0, 1), (3, 4), (6, 7), (1, 2), (4, 5), (7, 8), (0, 3),
    (5, 8), (4, 7), (3, 6), (1, 4), (2, 5), (4, 7), (4, 2), (6, 4), (4, 2),
)  # fmt: skip


@dataclass(frozen=True)
class BackgroundConfig:
    """Parameters of `MedianBackground`."""

    learning_s: float = parameter(
        0.8, 'time in which the first background is learned; nothing is seen [s]', minimum=0.0
    )
    renewal_s: float = parameter(
        20.0,
        'time over which later backgrounds are learned; the first ones are shorter [s]',
        minimum=0.0,
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
        12.0, 'difference that is foreground at least [grey levels]', minimum=1.0, maximum=255.0
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


def smoother(model: Image, candidate: Image) -> Image:
    """
    Return the model, exchanged for the candidate where the latter has clearly weaker edges.

    Whoever stands in one of the two adds edges to it; what belongs to the scene is in both.
    """
    energy = [
        cv2.blur(
            cv2.cvtColor(
                cv2.morphologyEx(image, cv2.MORPH_GRADIENT, KERNEL), cv2.COLOR_BGR2GRAY
            ).astype(np.float32),
            (WINDOW_PX, WINDOW_PX),
        )
        for image in (model, candidate)
    ]
    better = (energy[0] - energy[1] > EDGE_MARGIN).astype(np.uint8)
    chosen = model.copy()
    cv2.copyTo(candidate, better, chosen)
    return chosen


class MedianBackground:
    """
    Approximate median: each step moves every pixel of the model one grey level to the picture.

    The first model is the median of nine pictures. Medians over longer times correct it where
    they are smoother, so who stood still at the start leaves no hole. Foreground pixels move more
    slowly. The threshold follows the noise that is measured in the background (event-tracking
    paper, sections 3.1 and 4.2; equation (1) with the largest of the channels' differences).

    Attributes
    ----------
    model : (h, w, 3) uint8 array or None
        The background.
    difference : (h, w) uint8 array
        Largest of the channels' differences of the last picture from the model.
    noise : float or None
        Standard deviation of a channel's noise, grey levels.

    """

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config
        self.restart()

    def begin(self, picture: Image) -> None:
        """Take a (height, width, 3) uint8 picture without moving objects for the background."""
        self._take(picture.copy())
        self._length_s = self._config.renewal_s

    def restart(self) -> None:
        """Forget everything and learn anew."""
        self.model: Image | None = None
        self.difference: Image = np.zeros((0, 0), np.uint8)
        self.noise: float | None = None
        self._samples: list[Image] = []
        self._band = 0
        self._next_sample_ns = 0
        self._length_s = self._config.learning_s
        self._next_update_ns = 0
        self._updates = 0

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
            255 where the picture differs from the background, until the next call; None while it
            is learned.

        """
        self._sample(image, stamp_ns)
        if self.model is None:
            return None
        work = self._work
        measured = subtract(image, self.model, self.difference) / MEDIAN_OF_LARGEST
        self.noise = measured if self.noise is None else self.noise
        mask = work.mask
        cv2.threshold(self.difference, self.threshold, 255, cv2.THRESH_BINARY, mask)
        if cv2.countNonZero(mask) > self._config.relearn_fraction * mask.size:
            self.restart()
            return None
        self.noise += (measured - self.noise) * NOISE_SHARE
        if stamp_ns >= self._next_update_ns:
            self._update(image, mask)
            self._next_update_ns = stamp_ns + round(self._config.update_period_s * 1e9)
        return mask

    def _sample(self, image: Image, stamp_ns: int) -> None:
        """Collect nine pictures, evenly in time, and take their median; then nine more."""
        if len(self._samples) == SAMPLES:
            self._renew_band()
            return
        if stamp_ns < self._next_sample_ns:
            return
        self._samples.append(image.copy())
        self._next_sample_ns = stamp_ns + round(self._length_s / SAMPLES * 1e9)
        if self.model is None and len(self._samples) == SAMPLES:
            self._take(median_of_nine(self._samples))
            self._begin_samples()

    def _take(self, model: Image) -> None:
        self.model, self._work = model, _Work(model.shape)
        self.difference = np.zeros(model.shape[:2], np.uint8)

    def _begin_samples(self) -> None:
        """Collect anew, over a longer time."""
        self._samples, self._band = [], 0
        self._length_s = min(3 * self._length_s, max(self._config.renewal_s, self._length_s))

    def _renew_band(self) -> None:
        """Renew one band of the model: all at once would make this picture late."""
        assert self.model is not None
        height, halo = len(self.model), WINDOW_PX
        top, bottom = (height * band // BANDS for band in (self._band, self._band + 1))
        low, high = max(top - halo, 0), min(bottom + halo, height)
        median = median_of_nine([sample[low:high] for sample in self._samples])
        chosen = smoother(self.model[low:high], median)
        self.model[top:bottom] = chosen[top - low : bottom - low]
        self._band += 1
        if self._band == BANDS:
            self._begin_samples()

    def _update(self, image: Image, mask: Image) -> None:
        """Move the model one grey level; foreground only now and then."""
        assert self.model is not None
        work = self._work
        cv2.min(cv2.add(self.model, work.one, work.colour), image, work.colour)
        moved = cv2.max(cv2.subtract(self.model, work.one, work.lower), work.colour, work.lower)
        self._updates += 1
        if self._updates % self._config.foreground_slowdown:
            cv2.copyTo(moved, cv2.bitwise_not(mask), self.model)
        else:
            np.copyto(self.model, moved)


class _Work:
    """Pictures that are written anew each time; allocating them costs more than filling them."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.colour, self.lower = np.empty(shape, np.uint8), np.empty(shape, np.uint8)
        self.one = np.ones(shape, np.uint8)
        self.mask = np.empty(shape[:2], np.uint8)
