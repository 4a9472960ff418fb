"""Appearance templates: histograms of hue and brightness, and their distance."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

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
    pixels = []
    for left, top, width, height in box.tolist():
        part = np.s_[max(top, 0) : top + height, max(left, 0) : left + width]
        pixels.append(image[part][mask[part] > 0])
    count = np.array([len(each) for each in pixels], np.int64)
    if not count.sum():
        return np.zeros((len(box), TEMPLATE_SIZE))
    hsv = cv2.cvtColor(np.concatenate(pixels)[None], cv2.COLOR_BGR2HSV)[0]
    first_bin = np.repeat(np.arange(len(box)) * TEMPLATE_SIZE, count)
    saturation = hsv[:, 1] / 255.0
    hue = first_bin + hsv[:, 0] // (180 // HUE_BINS)
    grey = first_bin + HUE_BINS + (hsv[:, 2].astype(np.int64) * GREY_BINS) // 256
    size = len(box) * TEMPLATE_SIZE
    total = np.bincount(hue, saturation, size) + np.bincount(grey, 1 - saturation, size)
    result: NDArray[np.float64] = total.reshape(-1, TEMPLATE_SIZE) / np.maximum(count, 1)[:, None]
    return result


def bhattacharyya_distance(
    first: NDArray[np.floating], second: NDArray[np.floating]
) -> NDArray[np.float64]:
    """
    Return the (n, m) distances of (n, 48) and (m, 48) templates: 0 the same, 1 nothing in common.

    An empty template tells nothing: its distance to all is one half.
    """
    coefficient = np.sqrt(first).astype(np.float64) @ np.sqrt(second).astype(np.float64).T
    distance = np.sqrt(np.clip(1 - coefficient, 0.0, 1.0))
    known = np.outer(first.sum(axis=1) > 0, second.sum(axis=1) > 0)
    result: NDArray[np.float64] = np.where(known, distance, 0.5)
    return result
