"""Distance to the nearest edge along lines of several directions (section 4.3, equation 3)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.likelihood_grid.edges import ORIENTATIONS, Edges

Bytes = NDArray[np.uint8]
Window = tuple[slice, slice]

STEPS = (1, 2, 4, 8)
"""Each step looks twice as far: all distances up to their sum are found."""
FARTHEST_PX = sum(STEPS)
MARGIN_PX = FARTHEST_PX + STEPS[-1]
"""Around the image: what spreads from its edges, and what is looked at for that, lies within."""
NONE = 255
"""Distance where no edge is near."""
TURN = 1
"""Edges count whose gradient differs from the direction by so many orientations at most."""


class OrientedDistance:
    """
    Oriented distance transform of images of one size, truncated.

    The distance at a pixel is that to the nearest edge on the line through it in one direction;
    edges that run along the line do not count (`TURN`). It is the minimum over shifts by 1, 2,
    4 .. px along the line: sums of those reach every distance up to `FARTHEST_PX`. Only the part
    of the image where there are edges is looked at.

    Parameters
    ----------
    size : (int, int)
        Width and height of the images, px.

    Attributes
    ----------
    distance : (12, h + 2 m, w + 2 m) uint8 array
        By direction, px, with a margin m of `MARGIN_PX`; `NONE` where no edge is near.

    """

    def __init__(self, size: tuple[int, int]) -> None:
        width, height = size
        padded = height + 2 * MARGIN_PX, width + 2 * MARGIN_PX
        self._width = width
        self._filled: Window = (slice(0, 0), slice(0, 0))
        self.distance = np.full((ORIENTATIONS, *padded), NONE, np.uint8)
        self._other = np.full(padded, NONE, np.uint8)
        self._shifted = np.empty(padded[0] * padded[1], np.uint8)
        angle = np.arange(ORIENTATIONS) * np.pi / ORIENTATIONS
        ray = np.column_stack([np.sin(angle), np.cos(angle)])  # down, across
        self._shifts = np.rint(np.multiply.outer(STEPS, ray)).astype(int).tolist()

    def transform(self, edges: Edges) -> Bytes:
        """Compute and return `distance`, which the next image overwrites."""
        self.distance[(slice(None), *self._filled)] = NONE
        self._other[self._filled] = NONE
        if not len(edges.pixel):
            return self.distance
        row, column = np.divmod(edges.pixel, self._width)
        beyond = MARGIN_PX - FARTHEST_PX
        top, bottom = int(row[0]) + beyond, int(row[-1]) + MARGIN_PX + FARTHEST_PX + 1
        left, right = int(column.min()) + beyond, int(column.max()) + MARGIN_PX + FARTHEST_PX + 1
        window = slice(top, bottom), slice(left, right)
        self._filled = window
        place = (row + MARGIN_PX) * self._other.shape[1] + column + MARGIN_PX
        by_direction = [place[edges.direction == each] for each in range(ORIENTATIONS)]
        for direction in range(ORIENTATIONS):
            for turn in range(-TURN, TURN + 1):
                counts = by_direction[(direction + turn) % ORIENTATIONS]
                self.distance[direction].ravel()[counts] = 0
            self._spread(direction, window)
        return self.distance

    def _spread(self, direction: int, window: Window) -> None:
        """Let distances grow from the edges along the lines of a direction."""
        one, other = self.distance[direction], self._other
        top, bottom = window[0].start, window[0].stop
        left, right = window[1].start, window[1].stop
        for step, shifts in zip(STEPS, self._shifts):
            down, across = shifts[direction]
            ahead = one[top + down : bottom + down, left + across : right + across]
            behind = one[top - down : bottom - down, left - across : right - across]
            shifted = self._shifted_window(bottom - top, right - left)
            cv2.min(ahead, behind, shifted)
            cv2.add(shifted, step, shifted)  # type: ignore[call-overload]
            cv2.min(one[window], shifted, other[window])
            one, other = other, one
        assert not len(STEPS) % 2  # the result is back where it began

    def _shifted_window(self, height: int, width: int) -> Bytes:
        return self._shifted[: height * width].reshape(height, width)
