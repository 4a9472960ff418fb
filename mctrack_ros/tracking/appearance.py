"""Appearance templates: histograms of hue and brightness, and their distance."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import TEMPLATE_SIZE

HUE_BINS = 36
GREY_BINS = TEMPLATE_SIZE - HUE_BINS


def colour_template(image: NDArray[np.uint8], mask: NDArray[np.uint8]) -> NDArray[np.float32]:
    """
    Count the colours of the foreground.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR picture.
    mask : (h, w) uint8 array
        Not zero where a pixel counts.

    Returns
    -------
    (48,) float32 array
        Sums to 1: 36 bins of hue, each pixel weighted by its saturation, and 12 of brightness,
        weighted by the rest. Zero where nothing counts.

    """
    pixels = image[mask > 0]
    if not len(pixels):
        return np.zeros(TEMPLATE_SIZE, np.float32)
    hsv = cv2.cvtColor(pixels[None], cv2.COLOR_BGR2HSV)[0]
    saturation = hsv[:, 1] / 255.0
    hue = np.bincount(hsv[:, 0] // (180 // HUE_BINS), saturation, HUE_BINS)
    grey = np.bincount((hsv[:, 2].astype(np.intp) * GREY_BINS) // 256, 1 - saturation, GREY_BINS)
    return (np.concatenate([hue, grey]) / len(pixels)).astype(np.float32)


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
