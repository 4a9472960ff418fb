"""The paper's likelihood: Bhattacharyya distances of many boxes, by integral histograms."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_3D, FLOATS_1D, FLOATS_3D, compiled
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.perception.belief.observation import PERSON_ROWS
from mctrack_ros.tracking.appearance import HALF, NO_BALANCE, colour_bins

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]


def squared_distances(image: Image, box: Floats, reference: Floats) -> Floats:
    """
    Return the squares of the Bhattacharyya distances of boxes to references, (k, n).

    What lies outside the image has nothing in common with anything (Pérez et al. 2002).

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR image.
    box : (k, n, 4) array
        Left, top, width, height, px, of n boxes that lie about together, k times.
    reference : (k, 48) array
        Histograms by `box_templates`.

    """
    shared = np.einsum('kni,ki->kn', root_templates(image, box), np.sqrt(reference))
    return np.asarray(1.0 - shared)


def root_templates(image: Image, box: Floats) -> Floats:
    """
    Return the roots of the boxes' histograms, (k, n, 48); products of two are Bhattacharyya's.

    The squares of each sum to the share of the box that is in the image.
    """
    roots: Floats = _root_templates(
        np.ascontiguousarray(image), np.ascontiguousarray(box), NO_BALANCE
    )
    return roots


@compiled(types.f8[:, :, ::1](BYTES_3D, FLOATS_3D, FLOATS_1D))
def _root_templates(image: Image, box: Floats, balance: Floats) -> Floats:
    rows, columns = image.shape[0], image.shape[1]
    roots = np.zeros((len(box), box.shape[1], TEMPLATE_SIZE))
    line = np.zeros(HALF, np.float32)
    for k in range(len(box)):
        lowest, highest = np.array([np.inf, np.inf]), np.array([-np.inf, -np.inf])
        height = 0.0
        for n in range(box.shape[1]):
            height += box[k, n, 3] / box.shape[1]
            for axis in range(2):
                lowest[axis] = min(lowest[axis], box[k, n, axis])
                highest[axis] = max(highest[axis], box[k, n, axis] + box[k, n, 2 + axis])
        left, top = max(int(lowest[0]), 0), max(int(lowest[1]), 0)
        step = max(int(height / PERSON_ROWS), 1)
        wide = (min(int(np.ceil(highest[0])), columns) - left + step - 1) // step
        high = (min(int(np.ceil(highest[1])), rows) - top + step - 1) // step
        if wide < 1 or high < 1:
            continue
        sums = np.zeros((high + 1, wide + 1, HALF), np.float32)
        for row in range(high):
            line[:] = 0
            for column in range(wide):
                pixel = image[top + row * step, left + column * step]
                hue, grey, weight = colour_bins(
                    balance, float(pixel[0]), float(pixel[1]), float(pixel[2])
                )
                line[hue] += weight
                line[grey] += 1.0 - weight
                above, here = sums[row, column + 1], sums[row + 1, column + 1]
                for bin in range(HALF):
                    here[bin] = above[bin] + line[bin]
        for n in range(box.shape[1]):
            x0, y0 = (box[k, n, 0] - left) / step, (box[k, n, 1] - top) / step
            width, half = box[k, n, 2] / step, box[k, n, 3] / step / 2
            west, east = min(max(round(x0), 0), wide), min(max(round(x0 + width), 0), wide)
            for part in range(2):
                y = y0 + part * half
                north, south = min(max(round(y), 0), high), min(max(round(y + half), 0), high)
                inside = float((east - west) * (south - north))
                if inside <= 0.0:
                    continue
                area = 2 * max(width * half, inside)
                for bin in range(HALF):
                    count = (
                        sums[south, east, bin] - sums[north, east, bin]
                        - sums[south, west, bin] + sums[north, west, bin]
                    )  # fmt: skip
                    roots[k, n, part * HALF + bin] = np.sqrt(max(count, np.float32(0)) / area)
    return roots
