"""The background as the median of images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SAMPLES = 9
ROWS = 16  # of an image at once: few images in memory twice
# Compare-exchange network whose middle element is the median of nine (Smith 1996).
MEDIAN_OF_NINE = (
    (1, 2), (4, 5), (7, 8), (0, 1), (3, 4), (6, 7), (1, 2), (4, 5), (7, 8), (0, 3),
    (5, 8), (4, 7), (3, 6), (1, 4), (2, 5), (4, 7), (4, 2), (6, 4), (4, 2),
)  # fmt: skip


def median_of_nine(images: list[Image]) -> Image:
    """Return the pixel-wise median of nine images."""
    work: list[Image] = list(images)
    for low, high in MEDIAN_OF_NINE:
        smaller, larger = cv2.min(work[low], work[high]), cv2.max(work[low], work[high])
        work[low], work[high] = smaller, larger  # type: ignore[assignment]
    return work[4]


def spread_median(images: list[Image]) -> Image:
    """
    Return the pixel-wise median of at most 255 images spread over a recording, (h, w, 3) uint8.

    Bit by bit from the highest: the largest value that at most half of the images are below. That
    takes a third of the time of a partial sort.
    """
    parts = range(0, len(images[0]), ROWS)
    return np.concatenate(
        [_median(np.stack([image[top : top + ROWS] for image in images])) for top in parts]
    )


def _median(stack: Image) -> Image:
    """Return the element in the middle along the first axis."""
    middle = len(stack) // 2
    found = np.zeros(stack.shape[1:], np.uint8)
    for bit in (128, 64, 32, 16, 8, 4, 2, 1):
        tried = found | np.uint8(bit)
        below = np.add.reduce((stack < tried).view(np.uint8), axis=0, dtype=np.uint8)
        np.copyto(found, tried, where=below <= middle)
    return found
