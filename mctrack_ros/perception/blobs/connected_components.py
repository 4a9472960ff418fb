"""Foreground as runs of pixels along rows, compared only where there is any; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled, inner

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int64]
Words = NDArray[np.uint64]
Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

WORD = 8  # pixels
BLOCK = 8  # words


class Runs(NamedTuple):
    """
    Runs of foreground, row by row, from left to right; between two there is background.

    Attributes
    ----------
    first, last : (n,) int64 array
        The first column of a run, and the first behind it.
    row : (h + 1,) int64 array
        Where the runs of each row begin; the runs' number at the end.

    """

    first: Ints
    last: Ints
    row: Ints


class Strength(NamedTuple):
    """
    What of a blob joins persons: not its rim.

    JPEG keeps colour more coarsely than brightness, so that it bleeds over two pixels: what
    differs from the background in colour counts less than what is brighter or darker.

    Attributes
    ----------
    share : float
        Contrast with the background below which nothing joins, as a share of the blob's mean.
    colour : float
        How much a difference in colour counts, as a share of one in brightness.

    """

    share: float
    colour: float


@inner
def _occupied(words: Words) -> Bools:
    """Return which blocks of words are not wholly zero; behind the last is one more."""
    occupied = np.ones(len(words) // BLOCK + 1, np.bool_)
    for block in range(len(words) // BLOCK):
        part, found = words[block * BLOCK : (block + 1) * BLOCK], np.uint64(0)
        for index in range(BLOCK):
            found |= part[index]
        occupied[block] = found != 0
    return occupied


@inner
def _next_set(pixels: Bytes, words: Words, occupied: Bools, place: int, stop: int) -> int:
    """Return the first place that is not zero, at most `stop`."""
    while place < stop:
        if place % WORD == 0:
            word = place // WORD
            if not occupied[word // BLOCK]:
                place = (word // BLOCK + 1) * BLOCK * WORD
                continue
            if word < len(words) and words[word] == 0:
                place += WORD
                continue
        if pixels[place]:
            return place
        place += 1
    return stop


@inner
def _doubled(array: Ints) -> Ints:
    """Return an array of twice the size."""
    larger = np.empty(2 * len(array), np.int64)
    for index in range(len(array)):
        larger[index] = array[index]
    return larger


@inner
def runs_of(mask: Bytes) -> Runs:
    """Return the runs of what is not zero in an (h, w) mask."""
    height, width = mask.shape
    pixels = mask.reshape(-1)
    words = pixels[: len(pixels) // WORD * WORD].view(np.uint64)
    occupied = _occupied(words)
    first, last = np.empty(1024, np.int64), np.empty(1024, np.int64)
    row, count = np.zeros(height + 1, np.int64), 0
    for y in range(height):
        start, stop = y * width, (y + 1) * width
        place = _next_set(pixels, words, occupied, start, stop)
        while place < stop:
            if count == len(first):
                first, last = _doubled(first), _doubled(last)
            first[count] = place - start
            while place < stop and pixels[place]:
                place += 1
            last[count] = place - start
            count += 1
            place = _next_set(pixels, words, occupied, place, stop)
        row[y + 1] = count
    return Runs(first[:count], last[:count], row)


@inner
def _unite(parent: Ints, one: int, other: int) -> None:
    """Let two runs be of one component; its first run is the root."""
    while parent[one] != one:
        parent[one] = parent[parent[one]]
        one = parent[one]
    while parent[other] != other:
        parent[other] = parent[parent[other]]
        other = parent[other]
    if one < other:
        parent[other] = one
    else:
        parent[one] = other


@inner
def labels_of(runs: Runs) -> tuple[Ints, int]:
    """Return which component each run is in, as numbered by their first runs; how many."""
    parent = np.empty(len(runs.first), np.int64)
    for index in range(len(parent)):
        parent[index] = index
    for y in range(1, len(runs.row) - 1):
        a, b = runs.row[y - 1], runs.row[y]
        while a < runs.row[y] and b < runs.row[y + 1]:
            if runs.first[a] <= runs.last[b] and runs.first[b] <= runs.last[a]:
                _unite(parent, a, b)
            if runs.last[a] < runs.last[b]:
                a += 1
            else:
                b += 1
    count = 0
    for index in range(len(parent)):
        if parent[index] == index:
            parent[index] = count
            count += 1
        else:
            parent[index] = parent[parent[index]]
    return parent, count


@inner
def _contrast(blue: int, green: int, red: int, colour: int) -> int:
    """
    Return what changes of a pixel come to, in 256ths of a grey level.

    The brightness is that of JPEG (ITU-R BT.601); the colour differs by as much as the changes
    differ among themselves, and counts by as many 256ths.
    """
    spread = max(blue, green, red) - min(blue, green, red)
    return abs(29 * blue + 150 * green + 77 * red) + colour * spread


@inner
def strong_runs(
    mask: Bytes, image: Bytes, background: Bytes, part: Ints, strength: Strength
) -> Runs:
    """
    Return the runs of what stands out from the background.

    Only in a part of the image, and counted from there: left, top, right, bottom, px.
    """
    left, top, right, bottom = part
    height, width = max(bottom - top, 0), max(right - left, 0)
    colour, change = round(256 * strength.colour), np.empty(3, np.int64)
    contrast, total, pixels = np.zeros((height, width), np.int32), 0, 0
    for y in range(height):
        for x in range(width):
            row, column = top + y, left + x
            if mask[row, column]:
                for channel in range(3):
                    change[channel] = image[row, column, channel]
                    change[channel] -= background[row, column, channel]
                here = _contrast(change[0], change[1], change[2], colour)
                contrast[y, x] = here
                total += here
                pixels += 1
    weak = strength.share * total / max(pixels, 1)
    first = np.empty(height * (width // 2 + 1), np.int64)
    last, begin, count = np.empty_like(first), np.zeros(height + 1, np.int64), 0
    for y in range(height):
        inside = False
        for x in range(width):
            strong = contrast[y, x] > weak
            if strong and not inside:
                first[count] = x
                count += 1
            if strong:
                last[count - 1] = x + 1
            inside = strong
        begin[y + 1] = count
    return Runs(first[:count], last[:count], begin)


@compiled(types.f8[:, ::1](BYTES_2D))
def component_boxes(mask: Bytes) -> Floats:
    """
    Return the (n, 4) boxes of connected foreground: left, top, width, height, px.

    Parameters
    ----------
    mask : (h, w) uint8 array
        Foreground; not zero. Pixels that touch, also at corners, are connected.

    """
    runs = runs_of(mask)
    label, count = labels_of(runs)
    left, right = np.full(count, mask.shape[1]), np.zeros(count, np.int64)
    top, bottom = np.full(count, mask.shape[0]), np.zeros(count, np.int64)
    for y in range(mask.shape[0]):
        for index in range(runs.row[y], runs.row[y + 1]):
            one = label[index]
            left[one] = min(left[one], runs.first[index])
            right[one] = max(right[one], runs.last[index])
            top[one], bottom[one] = min(top[one], y), y + 1
    box = np.empty((count, 4))
    for one in range(count):
        box[one, 0], box[one, 1] = left[one], top[one]
        box[one, 2], box[one, 3] = right[one] - left[one], bottom[one] - top[one]
    return box
