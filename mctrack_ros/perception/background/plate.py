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
    """Return the pixel-wise median of images spread over a recording, (h, w, 3) uint8."""
    middle = len(images) // 2
    rows = [
        np.partition(np.stack([image[top : top + ROWS] for image in images]), middle, axis=0)
        for top in range(0, len(images[0]), ROWS)
    ]
    return np.concatenate([part[middle] for part in rows])
