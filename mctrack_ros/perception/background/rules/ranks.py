"""Medians of images, and which of two images of a place is the emptier."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SAMPLES = 9
WINDOW_PX = 13  # about the width of a person
EDGE_MARGIN = 3.0  # grey levels
KERNEL = np.ones((3, 3), np.uint8)
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


def smoother(model: Image, candidate: Image) -> Image:
    """
    Return the model, exchanged for the candidate where the latter has clearly weaker edges.

    Whoever stands in one of the two adds edges to it; what belongs to the scene is in both.
    """
    energy = [
        cv2.blur(
            cv2.cvtColor(
                cv2.morphologyEx(image, cv2.MORPH_GRADIENT, KERNEL), cv2.COLOR_BGR2GRAY
            ).astype(np.float32),
            (WINDOW_PX, WINDOW_PX),
        )
        for image in (model, candidate)
    ]
    better = (energy[0] - energy[1] > EDGE_MARGIN).astype(np.uint8)
    chosen = model.copy()
    cv2.copyTo(candidate, better, chosen)
    return chosen
