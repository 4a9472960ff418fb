"""Holes that something left in the background, told from things by whose outline it is."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, INTS_1D, compiled, inner
from mctrack_ros.config import parameter
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    Silhouettes,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Stationarity

Image = NDArray[np.uint8]
_CROSS = np.asarray(cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.uint8)
_MARGIN = 2  # px around a silhouette, beyond its outline


@dataclass(frozen=True)
class HoleConfig:
    """Parameters of `patched`."""

    edge_ratio: float = parameter(
        1.5,
        'how much stronger the outline must be in the background than in the image; 0: holes '
        'are not looked for in the image, as printed',
        minimum=0.0,
    )
    still_s: float = parameter(
        1.0,
        'time after which what has looked the same is tried for a hole apart from what moves '
        'before it; 0: never [s]',
        minimum=0.0,
    )
    least_area_px: float = parameter(
        100.0, 'smallest silhouette that may be a hole [px²]', minimum=1.0
    )


def patched(
    silhouettes: Silhouettes, image: Image, background: Background, config: HoleConfig
) -> Silhouettes:
    """
    Put silhouettes that are holes into the background and leave them out; beyond the paper.

    Whatever stood in the background when it was learned leaves a hole when it goes, without ever
    having been inserted. The outline of a hole is an edge of the background, that of a thing is
    one of the image.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of the image.
    image : (h, w, 3) uint8 array
        The smoothed image.
    background : Background
        Is changed.
    config : HoleConfig
        Parameters.

    """
    if config.edge_ratio == 0.0 or background.model is None:
        return silhouettes
    large = np.flatnonzero(silhouettes.shapes.area >= config.least_area_px).tolist()
    if not large:
        return silhouettes
    known = np.asarray(cv2.cvtColor(background.model, cv2.COLOR_BGR2GRAY), np.uint8)
    holes = [row for row in large if _is_hole(silhouettes, row, known, config)]
    for row in holes:
        window = _window(silhouettes, row)
        own = np.where(silhouettes.labels[window] == row + 1, 255, 0).astype(np.uint8)
        own = np.asarray(cv2.dilate(own, _CROSS), np.uint8)
        background.model[window][own > 0] = image[window][own > 0]
    return silhouettes.without(holes) if holes else silhouettes


def without_still_holes(
    mask: Image,
    grey: Image,
    image: Image,
    still: Stationarity,
    background: Background,
    components: ComponentConfig,
    config: HoleConfig,
) -> Image:
    """
    Patch holes that touch what moves, and return the mask without them; beyond the paper.

    A car that leaves is one silhouette with its hole until it has gone its own length. But the
    hole stands still.

    Parameters
    ----------
    mask : (h, w) uint8 array
        Foreground.
    grey, image : (h, w), (h, w, 3) uint8 array
        The smoothed image.
    still : Stationarity
        For how long its pixels have looked the same.
    background : Background
        Is changed.
    components : ComponentConfig
        How silhouettes are found.
    config : HoleConfig
        Parameters.

    """
    if config.edge_ratio == 0.0 or config.still_s == 0.0:
        return mask
    old = cv2.inRange(still.seconds, config.still_s, np.inf)
    if cv2.countNonZero(old) < config.least_area_px:
        return mask
    found = find_silhouettes(np.asarray(cv2.bitwise_and(old, mask), np.uint8), grey, components)
    left = patched(found, image, background, config)
    if len(left.shapes) == len(found.shapes):
        return mask
    hole = (found.labels > 0) & (left.row_of[found.labels] < 0)
    mask = np.where(hole, np.uint8(0), mask)
    still.seconds[hole] = 0.0
    return mask


def _is_hole(silhouettes: Silhouettes, row: int, model: Image, config: HoleConfig) -> bool:
    """Tell whether a silhouette's outline is in the background rather than in the image."""
    left, top, width, height = silhouettes.shapes.box[row].astype(int).tolist()
    shown, known = _outline(
        silhouettes.labels,
        np.ascontiguousarray(silhouettes.grey),
        model,
        row + 1,
        np.array([left, top, width, height]),
    )
    return bool(known > config.edge_ratio * shown)


@inner
def _edge(image: NDArray[np.generic], y: int, x: int) -> float:
    """Return the strength of the edge at a pixel, by Sobel's operator."""
    upper = image[y - 1, x - 1] + 2.0 * image[y - 1, x] + image[y - 1, x + 1]
    lower = image[y + 1, x - 1] + 2.0 * image[y + 1, x] + image[y + 1, x + 1]
    left = image[y - 1, x - 1] + 2.0 * image[y, x - 1] + image[y + 1, x - 1]
    right = image[y - 1, x + 1] + 2.0 * image[y, x + 1] + image[y + 1, x + 1]
    return float(abs(lower - upper) + abs(right - left))


@compiled(
    types.UniTuple(types.f8, 2)(
        types.Array(types.u2, 2, 'C', readonly=True),
        BYTES_2D,
        BYTES_2D,
        types.i8,
        INTS_1D,
    )
)
def _outline(
    labels: NDArray[np.uint16],
    grey: Image,
    model: Image,
    label: int,
    box: NDArray[np.int64],
) -> tuple[float, float]:
    """Return how strong edges are, in the image and in the background, along an outline."""
    shown, known = 0.0, 0.0
    left, top, width, height = box
    for y in range(max(top - 1, 1), min(top + height + 1, labels.shape[0] - 1)):
        for x in range(max(left - 1, 1), min(left + width + 1, labels.shape[1] - 1)):
            own = labels[y, x] == label
            if (
                (labels[y, x - 1] == label) != own
                or (labels[y, x + 1] == label) != own
                or (labels[y - 1, x] == label) != own
                or (labels[y + 1, x] == label) != own
            ):
                shown += _edge(grey, y, x)
                known += _edge(model, y, x)
    return shown, known


def _window(silhouettes: Silhouettes, row: int) -> tuple[slice, slice]:
    left, top, width, height = silhouettes.shapes.box[row].astype(int).tolist()
    return (
        slice(max(top - _MARGIN, 0), top + height + _MARGIN),
        slice(max(left - _MARGIN, 0), left + width + _MARGIN),
    )
