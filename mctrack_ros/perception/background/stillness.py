"""Foreground that lies still: holes that somebody left, and things that were put down."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, compiled, inner

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Labels = NDArray[np.int32]
WRITABLE_2D = types.Array(types.u1, 2, 'C')
WRITABLE_3D = types.Array(types.u1, 3, 'C')
LABELS = types.Array(types.i4, 2, 'C', readonly=True)
KERNEL = np.ones((3, 3), np.uint8)
TICK_S, OLDEST = 0.1, 255
"""Unit of ages, and the largest."""
GHOST_S = 1.0
"""Time for which a hole must lie still: passers-by do for less on terrace."""
EDGE_RATIO, EDGE_DIFFERENCE = 1.25, 6.0
"""Times, and grey levels, by which the background's edges along an outline exceed the image's:
by trial on simulated matches."""
OPEN_BORDER = 0.75
"""Least share of the border that is no foreground beyond: not a quiet part of a person."""
PROTECTED_SHARE = 0.5
REACH_PX = 2  # noise frays a border so far
AREA, OPEN, CLOSED, EDGES, MODEL_EDGES, PROTECTED = range(6)
"""Columns of what is measured of a region."""


class Stillness:
    """
    Remembers for how long each pixel of the foreground has looked the same.

    People sway: their outline changes from image to image. A connected region that does not, up
    to its border, is a thing, or a hole in the background that somebody left. Along the border
    of a thing the image has edges, along that of a hole the background has them.

    Parameters
    ----------
    still_s : float
        Time after which whatever lies still is background, s; holes are sooner.

    """

    def __init__(self, still_s: float) -> None:
        self._still = min(round(still_s / TICK_S), OLDEST)
        self._hole = min(round(GHOST_S / TICK_S), self._still)
        self._last: Image = np.zeros((0, 0, 3), np.uint8)
        self._age: Image = np.zeros((0, 0), np.uint8)

    def note(self, image: Image, mask: Image, level: int, seconds: float) -> None:
        """
        Look at an image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        mask : (h, w) uint8 array
            Its foreground, not 0.
        level : int
            Difference of two images that noise explains, grey levels.
        seconds : float
            Since the last one, s.

        """
        if self._age.shape != mask.shape:
            self._last, self._age = image.copy(), np.zeros_like(mask)
        _note(image, mask, level, round(seconds / TICK_S), self._last, self._age)

    def settle(self, image: Image, model: Image, mask: Image, protected: Image) -> bool:
        """
        Put the image into the background where something lies still for long enough.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        model : (h, w, 3) uint8 array
            Background; changed in place.
        mask : (h, w) uint8 array
            Foreground, 255.
        protected : (h, w) uint8 array
            Not 0 where somebody is known to be.

        Returns
        -------
        bool
            Whether anything was.

        """
        settled = False
        for age in sorted({self._hole, self._still}):
            label, found = self._regions(image, model, mask, protected, age)
            if not len(found):
                continue
            border = np.maximum(found[:, OPEN] + found[:, CLOSED], 1.0)
            chosen = found[:, OPEN] >= OPEN_BORDER * border
            if age < self._still:
                edges = found[:, [EDGES, MODEL_EDGES]] / np.maximum(found[:, OPEN, None], 1.0)
                chosen &= (edges[:, 1] > EDGE_RATIO * edges[:, 0]) & (
                    edges[:, 1] - edges[:, 0] > EDGE_DIFFERENCE
                )
            else:
                chosen &= found[:, PROTECTED] < PROTECTED_SHARE * found[:, AREA]
            if chosen.any():
                settled = True
                where = np.concatenate([[False], chosen])[label].astype(np.uint8) * 255
                wide = cv2.bitwise_and(cv2.dilate(where, KERNEL, iterations=2), mask)
                cv2.copyTo(image, wide, model)
                self._age[wide > 0] = 0
        return settled

    def _regions(
        self, image: Image, model: Image, mask: Image, protected: Image, age: int
    ) -> tuple[Labels, Floats]:
        """Return connected regions that are as old, by label from 1, and what is measured."""
        _, old = cv2.threshold(self._age, age - 1, 255, cv2.THRESH_BINARY)
        still = cv2.morphologyEx(old, cv2.MORPH_OPEN, KERNEL)
        if not cv2.countNonZero(still):
            return np.zeros(mask.shape, np.int32), np.zeros((0, 6))
        count, found = cv2.connectedComponents(still, connectivity=4)
        label = np.asarray(found, np.int32)
        return label, _measured(image, model, mask, protected, label, count)[1:]


@compiled(types.void(BYTES_3D, BYTES_2D, types.i8, types.i8, WRITABLE_3D, WRITABLE_2D))
def _note(image: Image, mask: Image, level: int, ticks: int, last: Image, age: Image) -> None:
    """Count for how long each pixel of the foreground has been about the same."""
    new, old = image.reshape(-1), last.reshape(-1)
    seen, count = mask.reshape(-1), age.reshape(-1)
    for index in range(len(seen)):
        if seen[index] == 0:
            count[index] = 0
            continue
        largest = np.uint8(0)
        for place in range(3 * index, 3 * index + 3):
            one, other = new[place], old[place]
            largest = max(largest, np.uint8(max(one, other) - min(one, other)))
        if count[index] == 0 or largest > level:
            count[index] = 1
            for place in range(3 * index, 3 * index + 3):
                old[place] = new[place]
            continue
        count[index] = np.uint8(min(count[index] + ticks, OLDEST))
        for place in range(3 * index, 3 * index + 3):
            one, other = new[place], old[place]
            old[place] = np.uint8(other + np.uint8(one > other) - np.uint8(one < other))


@inner
def _range(image: Image, y: int, x: int) -> int:
    """Return the sum of the channels' ranges over 3 x 3 about a pixel."""
    total = 0
    for channel in range(3):
        low, high = 255, 0
        for row in range(max(y - 1, 0), min(y + 2, image.shape[0])):
            for column in range(max(x - 1, 0), min(x + 2, image.shape[1])):
                value = int(image[row, column, channel])
                low, high = min(low, value), max(high, value)
        total += high - low
    return total


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_3D, BYTES_2D, BYTES_2D, LABELS, types.i8))
def _measured(
    image: Image, model: Image, mask: Image, protected: Image, label: Labels, count: int
) -> Floats:
    """Measure each region: its area, its border with the open and with other foreground, edges."""
    height, width = mask.shape
    found = np.zeros((count, 6))
    for y in range(height):
        for x in range(width):
            region = label[y, x]
            if region == 0:
                continue
            found[region, AREA] += 1.0
            found[region, PROTECTED] += protected[y, x] != 0
            is_open, is_closed = False, False
            for row, column in (
                (y - REACH_PX, x),
                (y + REACH_PX, x),
                (y, x - REACH_PX),
                (y, x + REACH_PX),
            ):
                inside = 0 <= row < height and 0 <= column < width
                if inside and label[row, column] != region:
                    is_open = is_open or mask[row, column] == 0
                    is_closed = is_closed or mask[row, column] != 0
            if is_open:
                found[region, OPEN] += 1.0
                found[region, EDGES] += _range(image, y, x) / 3.0
                found[region, MODEL_EDGES] += _range(model, y, x) / 3.0
            elif is_closed:
                found[region, CLOSED] += 1.0
    return found
