"""Real images with a mask of what moves, and the measure; needs OpenCV and NumPy alone."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SEQUENCES = {'highway': 470, 'office': 570, 'corridor': 0}
"""First image that is scored, by sequence."""
TIMED = 'highway'
"""Sequence of 320 x 240 px on which time is taken."""
MOVING = 255
NOT_SCORED = (85, 170)
PERIOD_NS = 40_000_000

Subtractor = Callable[[Image, int], 'Image | None']
"""Takes an image and its stamp, ns; returns foreground, not 0, or None: it still learns."""


def images(data: Path, sequence: str) -> list[tuple[int, Image, Image]]:
    """Return number, image and truth of each image of a sequence that has a truth."""
    folder = data / 'foreground' / sequence
    truths = {_number(path): path for path in (folder / 'groundtruth').iterdir()}
    found = []
    for path in sorted((folder / 'input').iterdir(), key=_number):
        image = cv2.imread(str(path))
        truth = cv2.imread(str(truths[_number(path)]), cv2.IMREAD_GRAYSCALE)
        if image is None or truth is None:
            raise OSError(f'{path}, or its truth, is no image that OpenCV reads')
        found.append((_number(path), np.asarray(image, np.uint8), np.asarray(truth, np.uint8)))
    return found


def measure(data: Path, new: Callable[[], Subtractor]) -> dict[str, float]:
    """
    Return F, precision and recall by sequence, and images a second of processor time.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    new : callable
        Begins a subtractor, which takes the images of one sequence.

    """
    cv2.setNumThreads(1)
    figures: dict[str, float] = {}
    for sequence, first in SEQUENCES.items():
        given, subtract = images(data, sequence), new()
        counts, seconds = np.zeros(3, np.int64), 0.0
        for index, (number, image, truth) in enumerate(given):
            began = time.process_time()
            mask = subtract(image, (index + 1) * PERIOD_NS)
            seconds += time.process_time() - began
            if number >= first:
                counts += _counts(mask, truth)
        right, false, missed = counts.tolist()
        figures[f'{sequence}.f'] = 2 * right / max(2 * right + false + missed, 1)
        figures[f'{sequence}.precision'] = right / max(right + false, 1)
        figures[f'{sequence}.recall'] = right / max(right + missed, 1)
        if sequence == TIMED:
            figures['images_a_second'] = len(given) / seconds
    return figures


def _counts(mask: Image | None, truth: Image) -> NDArray[np.int64]:
    """Return how many scored pixels are right, false and missed."""
    scored = ~np.isin(truth, NOT_SCORED)
    moves = (truth == MOVING) & scored
    found = np.zeros_like(moves) if mask is None else (mask > 0) & scored
    parts = found & moves, found & ~moves, moves & ~found
    return np.array([np.count_nonzero(part) for part in parts])


def _number(path: Path) -> int:
    return int(''.join(filter(str.isdigit, path.stem)))
