"""The background: a low-pass filter, with rectangles put in by hand of the tracker."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.backgrounds import low_pass

Grey = NDArray[np.uint8]
MEDIAN_OF_NORMAL = 0.6745  # median of a normal deviate's size, in standard deviations
SPARSE = 5  # noise is measured at every fifth pixel of every fifth row
NOISE_TIME_S = 2.0
NOISIEST = 20  # grey levels; a larger median difference is another picture, not noise


@dataclass(frozen=True)
class LowPassConfig:
    """Parameters of `LowPassBackground`."""

    threshold: float = parameter(
        7.0, 'difference above which a pixel is foreground at least [grey levels]', minimum=0.0
    )
    threshold_sigmas: float = parameter(
        5.0,
        'the same in standard deviations of the measured noise; 0: as printed',
        minimum=0.0,
    )
    shadow_share: float = parameter(
        0.13,
        'what is darker by no more than this share may be a shadow: neither foreground nor '
        'learned; 0: as printed',
        minimum=0.0,
        maximum=0.9,
    )
    follow_light: bool = parameter(
        True, 'what is not learned follows the brightness of the rest; false: as printed'
    )
    smoothing_px: int = parameter(
        3, 'pictures are averaged over squares of this side; 1: not', minimum=1, maximum=15
    )
    beta: float = parameter(
        0.1, 'share of a difference that is learned in one period', minimum=0.0, maximum=1.0
    )
    period_s: float = parameter(0.25, 'that period [s]', minimum=0.001)
    reset_share: float = parameter(
        0.6, 'foreground above which all is learned anew', minimum=0.0, maximum=1.0
    )


class LowPassBackground:
    """
    A low-pass filter for each pixel (silhouettes paper, section 2, eqs (1) and (2)).

    ``delta = |I - B|``; where it is not above the threshold, ``B += beta (I - B)``. The share is
    that of the time between two pictures, so the filter is the same at every rate.

    Attributes
    ----------
    model : (h, w) float32 array or None
        The background.
    noise : float
        Measured standard deviation of a background pixel's difference, grey levels.
    light : float
        Brightness since the start, as a share, as far as it is followed.

    """

    def __init__(self, config: LowPassConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Forget everything: the next picture is the background."""
        self.model: NDArray[np.float32] | None = None
        self.noise, self.light = 0.0, 1.0
        self._last_ns = self._next_ns = 0

    @property
    def threshold(self) -> float:
        """Difference above which a pixel is foreground, grey levels."""
        return max(self._config.threshold, self._config.threshold_sigmas * self.noise)

    def smoothed(self, grey: Grey) -> Grey:
        """Return a picture as it is compared and learned."""
        side = self._config.smoothing_px
        return grey if side == 1 else cv2.blur(grey, (side, side))  # type: ignore[return-value]

    def apply(self, grey: Grey, stamp_ns: int) -> Grey | None:
        """
        Learn from a smoothed picture and tell what in it is foreground.

        Parameters
        ----------
        grey : (h, w) uint8 array
            The picture.
        stamp_ns : int
            Its time, ns; later than the last.

        Returns
        -------
        (h, w) uint8 array or None
            255 where the picture differs; None if it has become the background.

        """
        seconds, self._last_ns = (stamp_ns - self._last_ns) * 1e-9, stamp_ns
        if self.model is None:
            self.restart_from(grey)
            return None
        assert self.model is not None
        model = np.asarray(cv2.convertScaleAbs(self.model), np.uint8)
        measures = stamp_ns >= self._next_ns
        if measures:
            self._next_ns = stamp_ns + round(self._config.period_s * 1e9)
            difference = np.asarray(cv2.absdiff(grey, model), np.uint8)
            self._measure_noise(difference, max(seconds, self._config.period_s))
        same, background = self._alike(grey, model)
        if cv2.countNonZero(same) < (1 - self._config.reset_share) * same.size:
            self.restart_from(grey)
            return None
        if self._config.follow_light and measures:
            self._follow_light(grey, same)
        self.learn(grey, same, seconds)
        return np.asarray(cv2.bitwise_not(background), np.uint8)

    def restart_from(self, grey: Grey) -> None:
        """Take a smoothed picture for the background."""
        self.model = grey.astype(np.float32)
        self.light = 1.0

    def _alike(self, grey: Grey, model: Grey) -> tuple[Grey, Grey]:
        """Return 255 where a picture is as the background, and where it may be a shadow, too."""
        step = int(self.threshold)
        low = np.asarray(cv2.subtract(model, step), np.uint8)  # type: ignore[call-overload]
        high = np.asarray(cv2.add(model, step), np.uint8)  # type: ignore[call-overload]
        same = cv2.inRange(grey, low, high)
        if self._config.shadow_share == 0.0:
            return same, same  # type: ignore[return-value]
        shaded = cv2.convertScaleAbs(model, alpha=1 - self._config.shadow_share)
        return same, cv2.inRange(grey, cv2.min(low, shaded), high)  # type: ignore[return-value]

    def _follow_light(self, grey: Grey, same: Grey) -> None:
        """Scale the background by how much brighter the picture is where it is alike."""
        assert self.model is not None
        sample = np.s_[::SPARSE, ::SPARSE]
        shown = same[sample] > 0
        known = float(self.model[sample][shown].sum())
        if known > 0.0:
            gain = float(grey[sample][shown].sum()) / known
            self.model *= np.float32(gain)
            self.light *= gain

    def insert(
        self,
        grey: NDArray[np.uint8 | np.float32],
        box: NDArray[np.integer],
        spared: NDArray[np.bool_] | None = None,
    ) -> Grey:
        """
        Copy a rectangle of a smoothed picture into the background.

        Parameters
        ----------
        grey : (h, w) uint8 or float32 array
            The picture.
        box : (4,) int array
            Left, top, width, height, px.
        spared : (height, width) bool array, optional
            Where it is left as it is.

        Returns
        -------
        (height, width) uint8 array
            What was there.

        """
        assert self.model is not None
        left, top, width, height = (int(value) for value in box)
        window = self.model[top : top + height, left : left + width]
        before = cv2.convertScaleAbs(window)
        shown = grey[top : top + height, left : left + width]
        np.copyto(window, shown, where=True if spared is None else ~spared)
        return before  # type: ignore[return-value]

    def learn(self, grey: Grey, where: Grey, seconds: float) -> None:
        """Let the background follow a smoothed picture where a mask is not zero."""
        assert self.model is not None
        low_pass(self.model, grey, where, seconds, self._config.beta, self._config.period_s)

    def restore(self, patch: Grey, box: NDArray[np.integer], mask: Grey) -> None:
        """Put back what `insert` returned, where a mask of the rectangle's size is not zero."""
        assert self.model is not None
        left, top, width, height = (int(value) for value in box)
        window = self.model[top : top + height, left : left + width]
        window[mask > 0] = patch[mask > 0]

    def _measure_noise(self, difference: NDArray[np.uint8], seconds: float) -> None:
        """Follow the median difference, in which foreground hardly counts."""
        sample = difference[::SPARSE, ::SPARSE].ravel()
        counts = np.bincount(sample, minlength=2).cumsum()
        middle = int(np.searchsorted(counts, sample.size / 2))
        if middle > NOISIEST:
            return
        below = counts[middle - 1] if middle else 0
        within = (sample.size / 2 - below) / max(counts[middle] - below, 1)
        measured = max(middle - 0.5 + within, 0.0) / MEDIAN_OF_NORMAL
        share = 1.0 if self.noise == 0.0 else 1 - np.exp(-seconds / NOISE_TIME_S)
        self.noise += share * (measured - self.noise)
