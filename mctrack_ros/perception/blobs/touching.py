"""Touching people: connected foreground, cut where it is weak."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, FLOATS_2D, compiled, inner
from mctrack_ros.perception.blobs.connected_components import (
    Runs,
    Strength,
    labels_of,
    strong_runs,
)
from mctrack_ros.perception.blobs.frame import Frame

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NOWHERE = -1  # of who is in no blob
STRENGTH = Strength(0.4, 0.15)
"""What joins persons; the values that put the fewest pixels between two persons wrong on simulated
matches."""
LEAST_COVER = 0.02
"""Share of a person's box that a part must fill."""

MARGIN_PX = 2
"""Blobs whose boxes, grown by this, overlap may be connected by what cleaning has cut."""

_STRENGTH = types.NamedUniTuple(types.f8, 2, Strength)


def contacts(box: Floats, blob_box: Floats, frame: Frame, strength: Strength = STRENGTH) -> Ints:
    """
    Tell which persons are connected by strong foreground.

    A blob's rim is blurred, so two persons who only stand close share it. Cut where it is weak,
    it falls into its parts; everyone is in the part that fills most of the own box. What is cut is
    the foreground as found: cleaning takes away the arm or leg, a pixel or two wide, by which two
    touch.

    Parameters
    ----------
    box : (n, 4) array
        The persons', px; not finite: not seen.
    blob_box : (m, 4) array
        The blobs', px.
    frame : Frame
        With its foreground.
    strength : Strength
        What is weak.

    Returns
    -------
    (n,) int64 array
        The same number for those that touch, directly or through others; -1: not seen.

    """
    blob_box, box = blob_box / frame.scale, box / frame.scale
    return _contacts(
        np.where(np.isfinite(box), box, 0.0),
        blob_box,
        frame.found,
        frame.image,
        frame.background,
        strength,
    )


@inner
def _meets(box: Floats, other: Floats) -> bool:
    """Tell whether two boxes overlap."""
    across = min(box[0] + box[2], other[0] + other[2]) - max(box[0], other[0])
    down = min(box[1] + box[3], other[1] + other[3]) - max(box[1], other[1])
    return bool(across > 0 and down > 0)


@inner
def _fullest(runs: Runs, label: Ints, count: int, box: Floats) -> tuple[int, int]:
    """Return the component that fills most of a box, the first of equals, and its pixels."""
    left, right = max(math.floor(box[0]), 0), math.ceil(box[0] + box[2])
    top, bottom = max(math.floor(box[1]), 0), math.ceil(box[1] + box[3])
    filled = np.zeros(count + 1, np.int64)
    for y in range(top, min(bottom, len(runs.row) - 1)):
        for index in range(runs.row[y], runs.row[y + 1]):
            shared = min(right, runs.last[index]) - max(left, runs.first[index])
            filled[label[index]] += max(shared, 0)
    fullest = 0
    for component in range(count):
        if filled[component] > filled[fullest]:
            fullest = component
    return fullest, filled[fullest]


@inner
def _regions(blob_box: Floats, width: int, height: int) -> Ints:
    """Return the (n, 4) parts of an image, left, top, right, bottom, px, in which blobs lie."""
    region, count = np.empty((len(blob_box), 4), np.int64), 0
    for blob in range(len(blob_box)):
        left, top = round(blob_box[blob, 0]), round(blob_box[blob, 1])
        right, bottom = left + round(blob_box[blob, 2]), top + round(blob_box[blob, 3])
        left, top = max(left - MARGIN_PX, 0), max(top - MARGIN_PX, 0)
        right, bottom = min(right + MARGIN_PX, width), min(bottom + MARGIN_PX, height)
        other = 0
        while other < count:  # taken in, it may meet those that it did not before
            known = region[other]
            across = min(right, known[2]) - max(left, known[0])
            if across > 0 and min(bottom, known[3]) - max(top, known[1]) > 0:
                left, top = min(left, known[0]), min(top, known[1])
                right, bottom = max(right, known[2]), max(bottom, known[3])
                count -= 1
                for side in range(4):
                    known[side] = region[count, side]
                other = 0
            else:
                other += 1
        region[count, 0], region[count, 1] = left, top
        region[count, 2], region[count, 3] = right, bottom
        count += 1
    return region[:count]


@compiled(
    types.i8[::1](FLOATS_2D, FLOATS_2D, BYTES_2D, BYTES_3D, BYTES_3D, _STRENGTH)
)  # fmt: skip
def _contacts(
    box: Floats, blob_box: Floats, mask: Bytes, image: Bytes, background: Bytes,
    strength: Strength,
) -> Ints:  # fmt: skip
    """Return what `contacts` does; all boxes in pixels of the mask."""
    found, free, (height, width) = np.full(len(box), NOWHERE), 0, mask.shape
    most, area, inside = np.empty(len(box)), np.empty(4), np.empty(4)
    rows = np.empty(len(box), np.int64)
    for row in range(len(box)):
        most[row] = LEAST_COVER * box[row, 2] * box[row, 3]
    regions = _regions(blob_box, width, height)
    for index in range(len(regions)):
        part, several = regions[index], 0
        area[0], area[1] = part[0], part[1]
        area[2], area[3] = part[2] - part[0], part[3] - part[1]
        for row in range(len(box)):
            if _meets(box[row], area):
                rows[several] = row
                several += 1
        if several == 0:
            continue
        runs = strong_runs(mask, image, background, part, strength)
        label, count = labels_of(runs)
        for place in range(several):
            row = rows[place]
            inside[0], inside[1] = box[row, 0] - part[0], box[row, 1] - part[1]
            inside[2], inside[3] = box[row, 2], box[row, 3]
            component, pixels = _fullest(runs, label, count, inside)
            if pixels > most[row]:
                found[row], most[row] = free + component, pixels
        free += count
    return found
