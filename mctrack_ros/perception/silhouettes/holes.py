"""Holes that something left in the background, told from things by whose outline it is."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.silhouettes.background import LowPassBackground
from mctrack_ros.perception.silhouettes.components import Silhouettes
from mctrack_ros.perception.silhouettes.features import AREA

Grey = NDArray[np.uint8]
_CROSS = np.asarray(cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.uint8)
_MARGIN = 2


@dataclass(frozen=True)
class HoleConfig:
    """Parameters of `patched`."""

    edge_ratio: float = parameter(
        1.5,
        'how much stronger the outline must be in the background than in the picture; 0: holes '
        'are not looked for in the picture, as printed',
        minimum=0.0,
    )
    least_area_px: float = parameter(
        100.0, 'smallest silhouette that may be a hole [px²]', minimum=1.0
    )


def patched(
    silhouettes: Silhouettes, background: LowPassBackground, config: HoleConfig
) -> Silhouettes:
    """
    Put silhouettes that are holes into the background and leave them out; beyond the paper.

    Whatever stood in the background when it was learned leaves a hole when it goes, without ever
    having been inserted. The outline of a hole is an edge of the background, that of a thing is
    one of the picture.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of the picture.
    background : LowPassBackground
        Is changed.
    config : HoleConfig
        Parameters.

    """
    if config.edge_ratio == 0.0 or background.model is None:
        return silhouettes
    large = silhouettes.shapes.vector[:, AREA] >= config.least_area_px
    holes = [
        row
        for row in np.flatnonzero(large).tolist()
        if _is_hole(silhouettes, row, background, config)
    ]
    for row in holes:
        window = _window(silhouettes, row)
        own = np.where(silhouettes.labels[window] == row + 1, 255, 0).astype(np.uint8)
        own = np.asarray(cv2.dilate(own, _CROSS), np.uint8)
        background.model[window][own > 0] = silhouettes.grey[window][own > 0]
    return silhouettes.without(holes) if holes else silhouettes


def _is_hole(
    silhouettes: Silhouettes, row: int, background: LowPassBackground, config: HoleConfig
) -> bool:
    """Tell whether a silhouette's outline is in the background rather than in the picture."""
    assert background.model is not None
    window = _window(silhouettes, row)
    own = (silhouettes.labels[window] == row + 1).astype(np.uint8)
    rim = cv2.morphologyEx(own, cv2.MORPH_GRADIENT, _CROSS) > 0
    shown = _edges(silhouettes.grey[window])[rim].mean()
    known = _edges(np.asarray(cv2.convertScaleAbs(background.model[window]), np.uint8))[rim].mean()
    return bool(known > config.edge_ratio * shown)


def _edges(grey: Grey) -> NDArray[np.int16]:
    """Return the strength of edges."""
    across, down = (cv2.Sobel(grey, cv2.CV_16S, *way) for way in ((1, 0), (0, 1)))
    return np.asarray(np.abs(across) + np.abs(down), np.int16)


def _window(silhouettes: Silhouettes, row: int) -> tuple[slice, slice]:
    left, top, width, height = silhouettes.shapes.box[row].astype(int).tolist()
    return (
        slice(max(top - _MARGIN, 0), top + height + _MARGIN),
        slice(max(left - _MARGIN, 0), left + width + _MARGIN),
    )
