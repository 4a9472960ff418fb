"""For how long each pixel of the foreground has looked the same."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, compiled, inner
from mctrack_ros.perception.background.model import Background

Image = NDArray[np.uint8]
FLOATS_3D = types.Array(types.f4, 3, 'C')
Seconds = NDArray[np.float32]

AVERAGED = 0.25  # share of a difference that is learned in one look
BLOCK = 32  # pixels of a row that are skipped at once where nothing happens
FORGET = 1.0  # times as fast as it was learned is forgotten what was seen at a pixel


class Stationarity:
    """
    Remembers at every pixel of the foreground what was seen there most of late, and how long.

    Somebody who passes before a parked car does not undo what is known of the car: each pixel
    holds one image element and the time that speaks for it, which grows while it is seen and
    shrinks while another is; at zero the other takes its place (majority vote of Boyer and Moore).

    Parameters
    ----------
    period_s : float
        Least time between two looks, s.

    Attributes
    ----------
    seconds : (h, w) float32 array
        Time that speaks for what is remembered, s.
    image : (h, w, 3) float32 array
        What is remembered.
    passed_s : float
        Time between the last two looks, s.

    """

    def __init__(self, period_s: float) -> None:
        self._period_ns = round(period_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self.seconds: Seconds = np.zeros((0, 0), np.float32)
        self.image: NDArray[np.float32] = np.zeros((0, 0, 3), np.float32)
        self.passed_s = 0.0
        self._most: Seconds = np.zeros((0, 0), np.float32)
        self._last_ns, self._tolerance = 0, 0.0

    def watch(self, image: Image, mask: Image, stamp_ns: int, tolerance: float) -> bool:
        """
        Look at an image, unless the last look was a moment ago.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        mask : (h, w) uint8 array
            Not zero where foreground.
        stamp_ns : int
            Its time, ns.
        tolerance : float
            Difference of any channel up to which two pixels are the same, grey levels.

        Returns
        -------
        bool
            Whether it was looked at.

        """
        self._tolerance = tolerance
        if self.seconds.shape != mask.shape:
            self.seconds, self.image = np.zeros(mask.shape, np.float32), image.astype(np.float32)
            self._most = np.zeros((mask.shape[0], -(-mask.shape[1] // BLOCK)), np.float32)
            self._last_ns = stamp_ns
            return True
        if stamp_ns - self._last_ns < self._period_ns:
            return False
        self.passed_s, self._last_ns = (stamp_ns - self._last_ns) * 1e-9, stamp_ns
        _look(image, mask, self.image, self.seconds, self._most, self.passed_s, tolerance)
        return True

    def still_for(
        self, image: Image, window: tuple[slice, slice], least_s: float
    ) -> NDArray[np.bool_]:
        """
        Tell which pixels have looked the same for long and still do.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        window : pair of slices
            Rows and columns to tell it of.
        least_s : float
            How long that must be, s.

        """
        old = self.seconds[window] >= least_s
        if old.any():
            apart = np.abs(image[window] - self.image[window]).max(axis=2)
            old &= apart <= self._tolerance
        return np.asarray(old)

    def teach(self, background: Background, image: Image, least_s: float) -> None:
        """Take all such pixels into a background: lines and specks, and whoever sleeps."""
        assert background.model is not None
        _learn(
            background.model,
            image,
            self.image,
            self.seconds,
            self._most,
            least_s,
            self._tolerance,
        )


@inner
def _apart(image: Image, remembered: NDArray[np.float32], y: int, x: int) -> float:
    """Return the largest of the channels' differences at a pixel."""
    largest = np.float32(0.0)
    for channel in range(3):
        largest = max(largest, abs(image[y, x, channel] - remembered[y, x, channel]))
    return float(largest)


@compiled(
    types.void(
        BYTES_3D,
        BYTES_2D,
        FLOATS_3D,
        types.Array(types.f4, 2, 'C'),
        types.Array(types.f4, 2, 'C'),
        types.f8,
        types.f8,
    )
)
def _look(
    image: Image,
    mask: Image,
    remembered: NDArray[np.float32],
    seconds: Seconds,
    most: Seconds,
    passed: float,
    tolerance: float,
) -> None:
    """
    Let the time at each pixel grow or shrink, and note the most in each block of a row.

    Where nothing is foreground and nothing is remembered, the mask alone is read.
    """
    height, width = mask.shape
    for y in range(height):
        for block in range(most.shape[1]):
            first, end = block * BLOCK, min((block + 1) * BLOCK, width)
            shown = most[y, block] > 0.0
            for x in range(first, end):
                shown |= mask[y, x] > 0
            if not shown:
                continue
            largest = np.float32(0.0)
            for x in range(first, end):
                known = seconds[y, x]
                if mask[y, x] == 0:
                    if known > 0.0:
                        seconds[y, x] = max(known - FORGET * passed, 0.0)
                elif known > 0.0 and _apart(image, remembered, y, x) <= tolerance:
                    seconds[y, x] = known + passed
                    for channel in range(3):
                        old = remembered[y, x, channel]
                        remembered[y, x, channel] += AVERAGED * (image[y, x, channel] - old)
                elif known > FORGET * passed:
                    seconds[y, x] = known - FORGET * passed
                else:
                    seconds[y, x] = 1e-6
                    for channel in range(3):
                        remembered[y, x, channel] = image[y, x, channel]
                largest = max(largest, seconds[y, x])
            most[y, block] = largest


@compiled(
    types.void(
        types.Array(types.u1, 3, 'C'),
        BYTES_3D,
        FLOATS_3D,
        types.Array(types.f4, 2, 'C'),
        types.Array(types.f4, 2, 'C'),
        types.f8,
        types.f8,
    )
)
def _learn(
    model: Image,
    image: Image,
    remembered: NDArray[np.float32],
    seconds: Seconds,
    most: Seconds,
    least_s: float,
    tolerance: float,
) -> None:
    """Copy to a background what has looked the same for long and still does."""
    for y in range(most.shape[0]):
        for block in range(most.shape[1]):
            if most[y, block] < least_s:
                continue
            for x in range(block * BLOCK, min((block + 1) * BLOCK, model.shape[1])):
                if seconds[y, x] < least_s or _apart(image, remembered, y, x) > tolerance:
                    continue
                seconds[y, x] = 0.0
                for channel in range(3):
                    model[y, x, channel] = np.uint8(round(remembered[y, x, channel]))
