"""How much rather the pixels of many boxes are a target's than their surroundings'."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_3D, FLOATS_1D, FLOATS_2D, FLOATS_3D, INTS_2D, compiled
from mctrack_ros.tracking.appearance import HALF, NO_BALANCE, colour_bins

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

PERSON_ROWS = 32
"""Of an image every so many pixels count that a person has about so many rows."""
AROUND = 1.0
"""Surroundings reach so many heights of the mean box to either side; above and below, half."""
LEAST_ODDS = 0.05
"""Of a pixel of the reference: one whose colours are all around is not found anywhere."""
RARE, RARE_AROUND = 0.002, 0.01
"""Shares that any colour has at least: of a target, and around, where others may come in."""


def box_templates(image: Image, box: Floats) -> Floats:
    """
    Return the histograms, (n, 48), of both halves of (n, 4) boxes, px; each sums to 1, or is 0.

    A colour counts in the bin it is in, and a row in its half: as `log_odds` looks them up.
    """
    rounded = np.round(np.asarray(box, np.float64)).astype(np.int64).reshape(-1, 4)
    found: Floats = _box_templates(np.ascontiguousarray(image), rounded, NO_BALANCE)
    return found


@compiled(types.f8[:, ::1](BYTES_3D, INTS_2D, FLOATS_1D))
def _box_templates(image: Image, box: NDArray[np.int64], balance: Floats) -> Floats:
    templates = np.zeros((len(box), 2 * HALF))
    for index in range(len(box)):
        left, top, width, height = box[index]
        template, count = templates[index], 0
        for row in range(max(top, 0), min(top + height, image.shape[0])):
            half = 0 if 2 * (row - top) < height else HALF
            for column in range(max(left, 0), min(left + width, image.shape[1])):
                pixel = image[row, column]
                hue, grey, weight = colour_bins(
                    balance, float(pixel[0]), float(pixel[1]), float(pixel[2])
                )
                template[half + hue] += weight
                template[half + grey] += 1.0 - weight
                count += 1
        template /= max(count, 1)
    return templates


def log_odds(image: Image, box: Floats, reference: Floats) -> Floats:
    """
    Return by how much boxes look like targets, 0: like the background, 1: like the reference.

    That is the sum, over the pixels of a box, of the logarithms of the ratio of their colour's
    share in the reference to its share in the surroundings of all boxes, over the same sum for a
    box of mean size that has the reference's colours.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR image.
    box : (k, n, 4) array
        Left, top, width, height, px, of n boxes that lie about together, k times.
    reference : (k, 48) array
        Histograms by `box_templates`.

    Returns
    -------
    (k, n) array

    """
    found: Floats = _log_odds(
        np.ascontiguousarray(image),
        np.ascontiguousarray(box),
        np.ascontiguousarray(reference, np.float64),
        NO_BALANCE,
    )
    return found


@compiled(types.f8[:, ::1](BYTES_3D, FLOATS_3D, FLOATS_2D, FLOATS_1D))
def _log_odds(image: Image, box: Floats, reference: Floats, balance: Floats) -> Floats:
    rows, columns = image.shape[0], image.shape[1]
    result = np.zeros(box.shape[:2])
    for k in range(len(box)):
        low, high = np.array([np.inf, np.inf]), np.array([-np.inf, -np.inf])
        mean, count = np.zeros(4), box.shape[1]
        for n in range(count):
            for axis in range(2):
                low[axis] = min(low[axis], box[k, n, axis])
                high[axis] = max(high[axis], box[k, n, axis] + box[k, n, 2 + axis])
            mean += box[k, n] / count
        for axis in range(2):
            low[axis] = min(low[axis], mean[axis] - AROUND * mean[3] * (1 - 0.5 * axis))
            high[axis] = max(
                high[axis], mean[axis] + mean[2 + axis] + AROUND * mean[3] * (1 - 0.5 * axis)
            )
        left, top = max(int(low[0]), 0), max(int(low[1]), 0)
        step = max(int(mean[3] / PERSON_ROWS), 1)
        wide = (min(int(np.ceil(high[0])), columns) - left + step - 1) // step
        tall = (min(int(np.ceil(high[1])), rows) - top + step - 1) // step
        if wide < 1 or tall < 1:
            continue
        hues, greys = np.empty((tall, wide), np.int64), np.empty((tall, wide), np.int64)
        weights = np.empty((tall, wide))
        around = np.zeros(HALF)
        for row in range(tall):
            for column in range(wide):
                pixel = image[top + row * step, left + column * step]
                hue, grey, weight = colour_bins(
                    balance, float(pixel[0]), float(pixel[1]), float(pixel[2])
                )
                hues[row, column], greys[row, column] = hue, grey
                weights[row, column] = weight
                around[hue] += weight
                around[grey] += 1.0 - weight
        odds, whole = np.empty((2, HALF)), 0.0
        for part in range(2):
            own = reference[k, part * HALF : (part + 1) * HALF]
            for bin in range(HALF):
                share = own[bin] / max(own.sum(), 1e-9)
                rival = around[bin] / (tall * wide)
                odds[part, bin] = np.log((share + RARE) / (rival + RARE_AROUND))
                whole += share * odds[part, bin] / 2
        whole = max(whole, LEAST_ODDS) * mean[2] * mean[3] / step**2
        sums = np.zeros((2, tall + 1, wide + 1))
        for part in range(2):
            for row in range(tall):
                line = 0.0
                for column in range(wide):
                    weight = weights[row, column]
                    line += (
                        weight * odds[part, hues[row, column]]
                        + (1.0 - weight) * odds[part, greys[row, column]]
                    )
                    sums[part, row + 1, column + 1] = sums[part, row, column + 1] + line
        for n in range(count):
            x0, y0 = (box[k, n, 0] - left) / step, (box[k, n, 1] - top) / step
            width, half = box[k, n, 2] / step, box[k, n, 3] / step / 2
            west, east = min(max(round(x0), 0), wide), min(max(round(x0 + width), 0), wide)
            for part in range(2):
                y = y0 + part * half
                north, south = min(max(round(y), 0), tall), min(max(round(y + half), 0), tall)
                result[k, n] += (
                    sums[part, south, east] - sums[part, north, east]
                    - sums[part, south, west] + sums[part, north, west]
                )  # fmt: skip
            result[k, n] /= whole
    return result
