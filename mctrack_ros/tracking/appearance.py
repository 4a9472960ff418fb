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
    hue, grey, saturation = _bins(np.concatenate(pixels)[None])
    first_bin = np.repeat(np.arange(len(box)) * TEMPLATE_SIZE, count)
    hue, grey, saturation = first_bin + hue[0], first_bin + grey[0], saturation[0]
    size = len(box) * TEMPLATE_SIZE
    total = np.bincount(hue, saturation, size) + np.bincount(grey, 1 - saturation, size)
    result: NDArray[np.float64] = total.reshape(-1, TEMPLATE_SIZE) / np.maximum(count, 1)[:, None]
    return result


def colour_likelihood(
    image: NDArray[np.uint8], template: NDArray[np.floating]
) -> NDArray[np.float64]:
    """
    Return how likely each pixel's colour is under each template.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR picture.
    template : (n, 48) array
        Colours, as `colour_templates` counts them.

    Returns
    -------
    (n, h, w) float64 array
        Share of the template in the pixel's bins.

    """
    hue, grey, saturation = _bins(image)
    columns = template.T
    likelihood = saturation[..., None] * columns[hue] + (1 - saturation)[..., None] * columns[grey]
    return np.asarray(np.moveaxis(likelihood, -1, 0), np.float64)


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


def _bins(
    image: NDArray[np.uint8],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return each pixel's bin of hue, its bin of brightness, and the weight of the former."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    hue = hsv[..., 0].astype(np.int64) // (180 // HUE_BINS)
    grey = HUE_BINS + (hsv[..., 2].astype(np.int64) * GREY_BINS) // 256
    return hue, grey, np.asarray(hsv[..., 1] / 255.0, np.float64)
