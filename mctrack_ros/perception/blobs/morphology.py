"""Foreground without noise: opened, and the legs that opening cuts off given back; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled, inner
from mctrack_ros.perception.blobs.connected_components import Runs, runs_of

Bytes = NDArray[np.uint8]


def check_kernels(**sizes: int) -> None:
    """Refuse kernels that would shift what they clean; by name, px."""
    for name, size in sizes.items():
        if size % 2 == 0:
            raise ValueError(f'{name} is {size}, expected an odd number')


@inner
def _hang_legs(cleaned: Bytes, found: Runs, difference: Bytes, clear: float) -> None:
    """Add what was found and differs clearly below what is there, row by row, also aslant."""
    height, width = cleaned.shape
    for y in range(1, height):
        for index in range(found.row[y], found.row[y + 1]):
            for x in range(found.first[index], found.last[index]):
                if not cleaned[y, x] and difference[y, x] > clear:
                    left, right = max(x - 1, 0), min(x + 1, width - 1)
                    above = cleaned[y - 1, left] | cleaned[y - 1, x] | cleaned[y - 1, right]
                    cleaned[y, x] = above


@inner
def _eroded(runs: Runs, width: int) -> Runs:
    """Return the pixels about which all 3 x 3, as far as in the image, are foreground."""
    height = len(runs.row) - 1
    first = np.empty(3 * len(runs.first), np.int64)
    last, row, count = np.empty_like(first), np.zeros(height + 1, np.int64), 0
    for y in range(height):
        above, below = max(y - 1, 0), min(y + 1, height - 1)
        a, b, c = runs.row[above], runs.row[y], runs.row[below]
        while a < runs.row[above + 1] and b < runs.row[y + 1] and c < runs.row[below + 1]:
            low = max(runs.first[a], runs.first[b], runs.first[c])
            high = min(runs.last[a], runs.last[b], runs.last[c])
            a += runs.last[a] == high
            b += runs.last[b] == high
            c += runs.last[c] == high
            low, high = low + (low > 0), high - (high < width)
            if low < high:
                first[count], last[count] = low, high
                count += 1
        row[y + 1] = count
    return Runs(first[:count], last[:count], row)


@inner
def _complement(runs: Runs, width: int) -> Runs:
    """Return the pixels that are not foreground."""
    height = len(runs.row) - 1
    first = np.empty(len(runs.first) + height, np.int64)
    last, row, count = np.empty_like(first), np.zeros(height + 1, np.int64), 0
    for y in range(height):
        begin, end = runs.row[y], runs.row[y + 1]
        for index in range(begin, end + 1):
            left = runs.last[index - 1] if index > begin else 0
            right = runs.first[index] if index < end else width
            if left < right:
                first[count], last[count] = left, right
                count += 1
        row[y + 1] = count
    return Runs(first[:count], last[:count], row)


@compiled(types.u1[:, ::1](BYTES_2D, BYTES_2D, types.i8, types.f8))
def opened(mask: Bytes, difference: Bytes, size: int, clear: float) -> Bytes:
    """
    Remove what is narrower than a square, unless it clearly hangs below what is not.

    The legs of those far away are a pixel or two wide; without them they would seem to stand
    where their hips are, metres behind.

    Parameters
    ----------
    mask : (h, w) uint8 array
        Foreground; not zero.
    difference : (h, w) uint8 array
        From the background, grey levels.
    size : int
        Side of the square, odd, px.
    clear : float
        Difference above which what hangs below is a leg, grey levels.

    Returns
    -------
    (h, w) uint8 array
        Foreground, 255.

    """
    height, width = mask.shape
    found = runs = runs_of(mask)
    for _ in range(size // 2):
        runs = _eroded(runs, width)
    runs = _complement(runs, width)
    for _ in range(size // 2):  # eroding the background dilates the foreground
        runs = _eroded(runs, width)
    runs = _complement(runs, width)
    cleaned = np.zeros((height, width), np.uint8)
    for y in range(height):
        for index in range(runs.row[y], runs.row[y + 1]):
            cleaned[y, runs.first[index] : runs.last[index]] = 255
    _hang_legs(cleaned, found, difference, clear)
    return cleaned
