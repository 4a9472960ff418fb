"""Appearance templates: histograms of hue and brightness, and their distance."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, INTS_2D, compiled, inner
from mctrack_ros.interfaces import TEMPLATE_SIZE

HUE_BINS = 36
GREY_BINS = TEMPLATE_SIZE - HUE_BINS


def colour_templates(
    image: NDArray[np.uint8], mask: NDArray[np.uint8], box: NDArray[np.integer]
) -> NDArray[np.float64]:
    """
    Count the colours of the foreground in boxes.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR picture.
    mask : (h, w) uint8 array
        Not zero where a pixel counts.
    box : (n, 4) int array
        Left, top, width, height, px.

    Returns
    -------
    (n, 48) float64 array
        Each sums to 1: 36 bins of hue, each pixel weighted by its saturation, and 12 of
        brightness, weighted by the rest. Zero where nothing counts.

    """
    image, mask = np.ascontiguousarray(image), np.ascontiguousarray(mask)
    counted: NDArray[np.float64] = _count(image, mask, np.ascontiguousarray(box, np.int64))
    return counted


def bhattacharyya_distance(
    first: NDArray[np.floating], second: NDArray[np.floating]
) -> NDArray[np.float64]:
    """
    Return the (n, m) distances of (n, 48) and (m, 48) templates: 0 the same, 1 nothing in common.

    An empty template tells nothing: its distance to all is one half.
    """
    coefficient = np.sqrt(first).astype(np.float64) @ np.sqrt(second).astype(np.float64).T
    distance = np.sqrt(np.clip(1 - coefficient, 0.0, 1.0))
    distance[~first.any(axis=1)] = 0.5
    distance[:, ~second.any(axis=1)] = 0.5
    return np.asarray(distance)


@inner
def colour_bins(blue: float, green: float, red: float) -> tuple[int, int, float]:
    """
    Return a colour's bins of hue and of brightness, and the weight of the former.

    Parameters
    ----------
    blue, green, red : float
        0 to 255.

    """
    value = max(blue, green, red)
    spread = value - min(blue, green, red)
    grey = HUE_BINS + min(int(value * GREY_BINS) // 256, GREY_BINS - 1)
    if spread == 0.0:
        return 0, grey, 0.0
    if value == red:
        sixth = (green - blue) / spread
    elif value == green:
        sixth = 2.0 + (blue - red) / spread
    else:
        sixth = 4.0 + (red - green) / spread
    hue = int(np.floor(sixth * (HUE_BINS / 6.0))) % HUE_BINS
    return hue, grey, spread / value


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_2D, INTS_2D))
def _count(
    image: NDArray[np.uint8], mask: NDArray[np.uint8], box: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Add up every box pixel by pixel."""
    templates = np.zeros((len(box), TEMPLATE_SIZE))
    for index in range(len(box)):
        left, top, width, height = box[index]
        count = 0
        for row in range(max(top, 0), min(top + height, mask.shape[0])):
            for column in range(max(left, 0), min(left + width, mask.shape[1])):
                if mask[row, column]:
                    pixel = image[row, column]
                    hue, grey, weight = colour_bins(
                        float(pixel[0]), float(pixel[1]), float(pixel[2])
                    )
                    templates[index, hue] += weight
                    templates[index, grey] += 1.0 - weight
                    count += 1
        templates[index] /= max(count, 1)
    return templates
