"""Boxes of connected foreground, trimmed and joined to persons; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, FLOATS_2D, FLOATS_3D, compiled, inner
from mctrack_ros.perception.geometry.person_size import TALLEST, metre_at

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]

WIDEST, WIDEST_STRIDE = 1.2, 1.8
"""Width of one person who stands, and of one in full stride, in usual widths; by trial."""
JOIN_GAP = 0.25
"""Greatest gap between fragments, as a share of the person's height; by trial."""


@inner
def _excess(first: Floats, second: Floats, sizes: Floats, usual: tuple[float, float]) -> float:
    """Return the gap, px, between two boxes that may be one person; else infinity."""
    left, top = min(first[0], second[0]), min(first[1], second[1])
    right = max(first[0] + first[2], second[0] + second[2])
    bottom = max(first[1] + first[3], second[1] + second[3])
    gap_x = max(first[0], second[0]) - min(first[0] + first[2], second[0] + second[2])
    gap_y = max(first[1], second[1]) - min(first[1] + first[3], second[1] + second[3])
    gap = max(gap_x, gap_y)
    middle = (left + right) / 2
    lean = metre_at(sizes, middle, bottom)[2]
    across, upright, _, _ = metre_at(sizes, middle - lean * (bottom - top) / 2, bottom)
    width, height = across * usual[0], upright * usual[1]
    stacked = -gap_x >= 0.5 * min(first[2], second[2])
    widest = WIDEST_STRIDE if stacked else WIDEST
    fits = (
        right - left <= widest * width
        and bottom - top <= TALLEST * height
        and gap <= JOIN_GAP * height
    )
    return gap if fits else np.inf


@inner
def _is_before(first: Floats, second: Floats) -> bool:
    for side in range(4):
        if first[side] != second[side]:
            return bool(first[side] < second[side])
    return False


@compiled(types.f8[:, ::1](FLOATS_2D, types.f8))
def from_left_to_right(box: Floats, least_area: float) -> Floats:
    """Return the (n, 4) boxes that are not too small, by left, top, width and height."""
    ordered, count = np.empty(box.shape), 0
    for index in range(len(box)):
        if box[index, 2] * box[index, 3] < least_area:
            continue
        place = count
        while place and _is_before(box[index], ordered[place - 1]):
            for side in range(4):
                ordered[place, side] = ordered[place - 1, side]
            place -= 1
        for side in range(4):
            ordered[place, side] = box[index, side]
        count += 1
    return ordered[:count]


@compiled(types.f8[:, ::1](FLOATS_2D, FLOATS_3D, types.f8, types.f8))
def joined(box: Floats, sizes: Floats, width_m: float, height_m: float) -> Floats:
    """
    Join the closest fragments, again and again, while the union is no larger than one person.

    Parameters
    ----------
    box : (n, 4) array
        Left, top, width, height, px.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    width_m, height_m : float
        Usual size of a person, m.

    Returns
    -------
    (m, 4) array
        Boxes in the order of their first fragments.

    """
    box = box.copy()
    count = len(box)
    while count > 1:
        best, one, other = np.inf, 0, 0
        for first in range(count):
            for second in range(first + 1, count):
                excess = _excess(box[first], box[second], sizes, (width_m, height_m))
                if excess < best:
                    best, one, other = excess, first, second
        if best == np.inf:
            break
        left, top = min(box[one, 0], box[other, 0]), min(box[one, 1], box[other, 1])
        right = max(box[one, 0] + box[one, 2], box[other, 0] + box[other, 2])
        bottom = max(box[one, 1] + box[one, 3], box[other, 1] + box[other, 3])
        box[one, 0], box[one, 1] = left, top
        box[one, 2], box[one, 3] = right - left, bottom - top
        count -= 1
        for row in range(other, count):
            for side in range(4):
                box[row, side] = box[row + 1, side]
    return box[:count].copy()


@compiled(types.f8[:, ::1](BYTES_2D, BYTES_2D, FLOATS_2D, types.f8))
def trimmed(mask: Bytes, difference: Bytes, box: Floats, halo_share: float) -> Floats:
    """
    Trim boxes to what differs clearly from the background, and count the foreground in them.

    Around whatever stands out, compression and optics leave a rim that would move the foot.

    Parameters
    ----------
    mask, difference : (h, w) uint8 arrays
        Foreground, and difference from the background.
    box : (n, 4) array
        Left, top, width, height, px.
    halo_share : float
        Difference below which the rim is cut, as a share of the mean in the box.

    Returns
    -------
    (n, 5) array
        The boxes, px, and their foreground, px²; zero where nothing stands out.

    """
    result = np.zeros((len(box), 5))
    height, width = mask.shape
    for index in range(len(box)):
        left, top = max(round(box[index, 0]), 0), max(round(box[index, 1]), 0)
        right = min(left + round(box[index, 2]), width)
        bottom = min(top + round(box[index, 3]), height)
        count, total = 0, 0
        for y in range(top, bottom):
            for x in range(left, right):
                if mask[y, x]:
                    count += 1
                    total += difference[y, x]
        least = halo_share * total / max(count, 1)
        low_x, low_y, high_x, high_y = right, bottom, left, top
        for y in range(top, bottom):
            for x in range(left, right):
                if mask[y, x] and difference[y, x] > least:
                    low_x, high_x = min(low_x, x), max(high_x, x + 1)
                    low_y, high_y = min(low_y, y), max(high_y, y + 1)
        if high_x <= low_x:
            continue
        area = 0
        for y in range(low_y, high_y):
            for x in range(low_x, high_x):
                area += mask[y, x] > 0
        result[index, 0], result[index, 1] = low_x, low_y
        result[index, 2], result[index, 3] = high_x - low_x, high_y - low_y
        result[index, 4] = area
    return result
