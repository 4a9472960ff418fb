"""Who touches whom: connected foreground, cut where it is weak."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, FLOATS_2D, INTS_1D, compiled, inner
from mctrack_ros.perception.picture import Picture
from mctrack_ros.perception.runs import Runs, labels_of, strong_runs

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NOWHERE = -1


def contacts(blob: Ints, box: Floats, blob_box: Floats, picture: Picture, share: float) -> Ints:
    """
    Tell which persons are connected by strong foreground.

    A blob's rim is blurred, so two persons who only stand close share it. Cut where it differs
    from the background by less than a share of its mean, it falls into its parts; everyone is in
    the part that fills most of the own box.

    Parameters
    ----------
    blob : (n,) int64 array
        Row of the blob that each person is in; -1: not seen.
    box : (n, 4) array
        The persons', px.
    blob_box : (m, 4) array
        The blobs', px.
    picture : Picture
        With its foreground.
    share : float
        Of the blob's mean difference.

    Returns
    -------
    (n,) int64 array
        The same number for those that touch, directly or through others; -1: not seen.

    """
    mask, difference = picture.mask, picture.difference
    return _contacts(blob, box / picture.scale, blob_box / picture.scale, mask, difference, share)


@inner
def _fullest(runs: Runs, label: Ints, count: int, box: Floats) -> int:
    """Return the component that fills most of a box, the first of equals; `count`: none."""
    left, right = max(math.floor(box[0]), 0), math.ceil(box[0] + box[2])
    top, bottom = max(math.floor(box[1]), 0), math.ceil(box[1] + box[3])
    filled = np.zeros(count + 1, np.int64)
    for y in range(top, min(bottom, len(runs.row) - 1)):
        for index in range(runs.row[y], runs.row[y + 1]):
            shared = min(right, runs.last[index]) - max(left, runs.first[index])
            filled[label[index]] += max(shared, 0)
    return int(filled.argmax()) if filled.any() else count


@compiled(types.i8[::1](INTS_1D, FLOATS_2D, FLOATS_2D, BYTES_2D, BYTES_2D, types.f8))
def _contacts(
    blob: Ints, box: Floats, blob_box: Floats, mask: Bytes, difference: Bytes, share: float
) -> Ints:
    """Return what `contacts` does; all boxes in pixels of the mask."""
    found = np.where(blob >= 0, blob, NOWHERE)
    free, (height, width) = len(blob_box), mask.shape
    for shared in range(len(blob_box)):
        rows = np.flatnonzero(blob == shared)
        if len(rows) < 2:
            continue
        left, top = round(blob_box[shared, 0]), round(blob_box[shared, 1])
        right = min(left + round(blob_box[shared, 2]), width)
        bottom = min(top + round(blob_box[shared, 3]), height)
        runs = strong_runs(mask, difference, np.array([left, top, right, bottom]), share)
        label, count = labels_of(runs)
        for row in rows:
            inside = box[row] - np.array([left, top, 0.0, 0.0])
            found[row] = free + _fullest(runs, label, count, inside)
        free += count + 1
    return found
