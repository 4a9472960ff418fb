"""
Other background subtractors on the same images, in a Python environment of their own.

``python -m mctrack_experiments.real.foreground.peers DATA FILE`` writes their figures as JSON. It
needs OpenCV with its contributed modules; bgslibrary's are measured where it is installed.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.real.foreground.sequences import SEQUENCES, Subtractor, measure

Image = NDArray[np.uint8]
FILTERS = {'': 0, ', median of 5': 5}
"""Filters of the masks, px; the better one counts for a peer, by the mean F."""
SHADOW = 127
OPENCV = f'OpenCV {cv2.__version__}'
LIBRARY = {'subsense': 'bgslibrary', 'pawcs': 'bgslibrary'}
"""Where a peer is from, if not from OpenCV."""


def peers() -> dict[str, Callable[[], Any]]:
    """Return how each of the others is begun, with its defaults; all have ``apply``."""
    cv: Any = cv2
    found: dict[str, Callable[[], Any]] = {
        'mog2': cv.createBackgroundSubtractorMOG2,
        'knn': cv.createBackgroundSubtractorKNN,
    }
    if hasattr(cv, 'bgsegm'):
        found['gsoc'] = cv.bgsegm.createBackgroundSubtractorGSOC
    if find_spec('pybgs'):
        library = import_module('pybgs')
        found |= {'subsense': library.SuBSENSE, 'pawcs': library.PAWCS}
    return found


def filtered(new: Callable[[], Any], size: int) -> Callable[[], Subtractor]:
    """Return a peer as a `Subtractor` that leaves shadows out and filters its masks."""

    def begin() -> Subtractor:
        peer = new()

        def subtract(image: Image, _: int) -> Image | None:
            mask = peer.apply(image)
            if mask is None or not np.size(mask):
                return None
            found = np.where(mask > SHADOW, np.uint8(255), np.uint8(0))
            return np.asarray(cv2.medianBlur(found, size), np.uint8) if size else found

        return subtract

    return begin


def main() -> None:
    """Write the figures of all peers."""
    data, figures = Path(sys.argv[1]), dict[str, dict[str, Any]]()
    for name, new in peers().items():
        runs = {word: measure(data, filtered(new, size)) for word, size in FILTERS.items()}
        best = max(runs, key=lambda word: sum(runs[word][f'{one}.f'] for one in SEQUENCES))
        figures[name] = {'what': f'{LIBRARY.get(name, OPENCV)}{best}', 'figures': runs[best]}
        print(name, runs[best], file=sys.stderr, flush=True)
    Path(sys.argv[2]).write_text(json.dumps(figures))


if __name__ == '__main__':
    main()
