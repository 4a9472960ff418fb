"""The background: a low-pass filter, with rectangles put in by hand of the tracker."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.perception.background.light import BRIGHTEST, gains

Grey = NDArray[np.uint8]
MEDIAN_OF_NORMAL = 0.6745  # median of a normal deviate's size, in standard deviations
SPARSE = np.s_[::5, ::5]  # where noise and light are measured
NOISE_TIME_S = 2.0
LEAP = 2.0  # grey levels by which the difference grows when the light leaps
NOISIEST = 20  # grey levels; a larger median difference is another image, not noise


def low_pass(
    level: NDArray[np.float32],
    image: NDArray[np.uint8],
    where: NDArray[np.uint8],
    seconds: float,
    beta: float,
    period_s: float,
) -> None:
    """
    Let a background learn: ``B += beta (I - B)`` (silhouettes paper, eq. (2)).

    The share is that of the time between two images, so the filter is the same at every rate.

    Parameters
    ----------
    level : (h, w) float32 array
        The background; changed in place.
    image : (h, w) uint8 array
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
        3, 'images are averaged over squares of this side; 1: not', minimum=1, maximum=15
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
    that of the time between two images, so the filter is the same at every rate.

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
        """Forget everything: the next image is the background."""
        self.model: NDArray[np.float32] | None = None
        self.noise, self.light = 0.0, 1.0
        self._last_ns = self._next_ns = 0

    @property
    def threshold(self) -> float:
        """Difference above which a pixel is foreground, grey levels."""
        return max(self._config.threshold, self._config.threshold_sigmas * self.noise)

    def smoothed(self, grey: Grey) -> Grey:
        """Return an image as it is compared and learned."""
        side = self._config.smoothing_px
        return grey if side == 1 else cv2.blur(grey, (side, side))  # type: ignore[return-value]

    def apply(self, grey: Grey, stamp_ns: int) -> Grey | None:
        """
        Learn from a smoothed image and tell what in it is foreground.

        Parameters
        ----------
        grey : (h, w) uint8 array
            The image.
        stamp_ns : int
            Its time, ns; later than the last.

        Returns
        -------
        (h, w) uint8 array or None
            255 where the image differs; None if it has become the background.

        """
        seconds, self._last_ns = (stamp_ns - self._last_ns) * 1e-9, stamp_ns
        if self.model is None:
            self.restart_from(grey)
            return None
        assert self.model is not None
        measures = stamp_ns >= self._next_ns
        noise = self._apart(grey) / MEDIAN_OF_NORMAL
        if self._config.follow_light and noise > self.noise + LEAP and self._leaps(grey):
            noise = self._apart(grey) / MEDIAN_OF_NORMAL
        if measures:
            self._next_ns = stamp_ns + round(self._config.period_s * 1e9)
            self._learn_noise(noise, max(seconds, self._config.period_s))
        same, mask = np.empty_like(grey), np.empty_like(grey)
        lit = 1 - self._config.shadow_share
        alike = _compare(grey, self.model, int(self.threshold), lit, same, mask)
        if alike < (1 - self._config.reset_share) * same.size:
            self.restart_from(grey)
            return None
        if self._config.follow_light and measures:
            self._follow_light(grey, same)
        self.learn(grey, same, seconds)
        return mask

    def restart_from(self, grey: Grey) -> None:
        """Take a smoothed image for the background."""
        self.model = grey.astype(np.float32)
        self._saturated = np.zeros(grey.shape, np.bool_)
        self.light = 1.0

    def _leaps(self, grey: Grey) -> bool:
        """
        Follow a sudden change of light or gain, if that explains how an image differs.

        How bright what was saturated truly is shows only when it gets darker.
        """
        assert self.model is not None
        new, old = grey[SPARSE].reshape(-1, 1), self.model[SPARSE].reshape(-1, 1)
        gain = float(gains(new, np.rint(old).astype(np.uint8))[0])
        before, after = (np.median(np.abs(new - old * factor)) for factor in (1.0, gain))
        is_lit = bool(2 * after <= before)
        if is_lit:
            self._saturated |= self.model >= BRIGHTEST
            self._relight(gain)
            brighter = self._saturated & (grey > self.model)
            np.copyto(self.model, grey, where=brighter)
        return is_lit

    def _follow_light(self, grey: Grey, same: Grey) -> None:
        """Scale the background by how much brighter the image is where it is alike."""
        assert self.model is not None
        shown = same[SPARSE] > 0
        known = float(self.model[SPARSE][shown].sum())
        if known > 0.0:
            self._relight(float(grey[SPARSE][shown].sum()) / known)

    def _relight(self, gain: float) -> None:
        assert self.model is not None
        np.minimum(self.model * np.float32(gain), 255.0, out=self.model)
        self.light *= gain

    def insert(
        self,
        grey: NDArray[np.uint8 | np.float32],
        box: NDArray[np.integer],
        spared: NDArray[np.bool_] | None = None,
    ) -> Grey:
        """
        Copy a rectangle of a smoothed image into the background.

        Parameters
        ----------
        grey : (h, w) uint8 or float32 array
            The image.
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
        """Let the background follow a smoothed image where a mask is not zero."""
        assert self.model is not None
        low_pass(self.model, grey, where, seconds, self._config.beta, self._config.period_s)

    def restore(self, patch: Grey, box: NDArray[np.integer], mask: Grey) -> None:
        """Put back what `insert` returned, where a mask of the rectangle's size is not zero."""
        assert self.model is not None
        left, top, width, height = (int(value) for value in box)
        window = self.model[top : top + height, left : left + width]
        window[mask > 0] = patch[mask > 0]

    def _apart(self, grey: Grey) -> float:
        """Return the median difference from the background, in which foreground hardly counts."""
        assert self.model is not None
        known = cv2.convertScaleAbs(np.ascontiguousarray(self.model[SPARSE]))
        sample = np.asarray(cv2.absdiff(np.ascontiguousarray(grey[SPARSE]), known)).ravel()
        counts = np.bincount(sample, minlength=2).cumsum()
        middle = int(np.searchsorted(counts, sample.size / 2))
        below = counts[middle - 1] if middle else 0
        within = (sample.size / 2 - below) / max(counts[middle] - below, 1)
        return float(max(middle - 0.5 + within, 0.0))

    def _learn_noise(self, noise: float, seconds: float) -> None:
        if noise * MEDIAN_OF_NORMAL > NOISIEST:
            return
        share = 1.0 if self.noise == 0.0 else 1 - np.exp(-seconds / NOISE_TIME_S)
        self.noise += share * (noise - self.noise)


@compiled(
    types.i8(
        BYTES_2D,
        types.Array(types.f4, 2, 'C', readonly=True),
        types.i8,
        types.f4,
        types.Array(types.u1, 2, 'C'),
        types.Array(types.u1, 2, 'C'),
    )
)
def _compare(
    grey: Grey, model: NDArray[np.float32], step: int, lit: float, same: Grey, mask: Grey
) -> int:
    """
    Tell where an image is as the background, and where it is neither that nor in shadow.

    One pass over the image, where OpenCV takes eight.

    Parameters
    ----------
    grey : (h, w) uint8 array
        The image.
    model : (h, w) float32 array
        The background.
    step : int
        Difference above which a pixel is foreground, grey levels.
    lit : float
        Share of the background's brightness down to which a pixel may be in shadow.
    same, mask : (h, w) uint8 arrays
        Are written: 255 where the image is as the background; where it is foreground.

    Returns
    -------
    int
        Number of pixels that are as the background.

    """
    count = 0
    for y in range(grey.shape[0]):
        for x in range(grey.shape[1]):
            known = np.int32(np.rint(model[y, x]))
            seen = np.int32(grey[y, x])
            shaded = np.int32(np.rint(np.float32(known) * lit))
            bright = seen > known + step
            alike = (seen >= known - step) & ~bright
            same[y, x] = 255 if alike else 0
            mask[y, x] = 255 if bright | ((seen < known - step) & (seen < shaded)) else 0
            count += int(alike)
    return count
