"""From the foreground mask to silhouettes: opening, connected components, features."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.perception.blobs.connected_components import labels_of, runs_of
from mctrack_ros.perception.blobs.morphology import check_kernels
from mctrack_ros.perception.silhouettes.features import (
    AREA,
    BINS,
    HEIGHT,
    HISTOGRAM,
    PLACE,
    SIZE,
    WIDTH,
    Floats,
    Ints,
    Shapes,
)

Grey = NDArray[np.uint8]
MOST = 1000
"""Components of one image; with more it shows nothing that could be tracked."""


@dataclass(frozen=True)
class ComponentConfig:
    """Parameters of `find_silhouettes`."""

    opening_px: int = parameter(3, 'what is narrower is noise [px]', minimum=1, maximum=31)
    closing_px: int = parameter(
        7, 'gaps narrower than this are closed; 1: none, as printed [px]', minimum=1, maximum=63
    )

    learn_specks: bool = parameter(
        True, 'what is too narrow to be in a silhouette is learned; false: as printed'
    )

    def __post_init__(self) -> None:
        """Refuse even kernels."""
        check_kernels(opening_px=self.opening_px, closing_px=self.closing_px)


@dataclass(frozen=True, eq=False, slots=True)
class Silhouettes:
    """
    The connected foreground of an image (silhouettes paper, section 2).

    Attributes
    ----------
    shapes : Shapes
        One row a silhouette, in the order of their first pixels, row by row.
    labels : (h, w) uint16 array
        Connected component that a pixel is in; 0: background.
    row_of : (c,) int64 array
        Row of the silhouette that a component is in; -1 for the background.
    grey : (h, w) uint8 array
        The image.

    """

    shapes: Shapes
    labels: NDArray[np.uint16]
    row_of: Ints
    grey: Grey

    def without(self, rows: list[int]) -> Silhouettes:
        """Return all silhouettes but some."""
        kept = np.setdiff1d(np.arange(len(self.shapes)), rows)
        renamed = np.full(len(self.shapes) + 1, -1)
        renamed[kept] = np.arange(len(kept))
        return Silhouettes(self.shapes.select(kept), self.labels, renamed[self.row_of], self.grey)


def find_silhouettes(mask: Grey, grey: Grey, config: ComponentConfig) -> Silhouettes:
    """
    Open a mask and collect its connected components; pixels that touch at corners are connected.

    Parameters
    ----------
    mask : (h, w) uint8 array
        255 where foreground.
    grey : (h, w) uint8 array
        The image.
    config : ComponentConfig
        Parameters.

    Returns
    -------
    Silhouettes
        Empty if there are more than `MOST` components: that is noise.

    """
    mask = np.ascontiguousarray(cleaned(mask, config))
    labels = np.zeros(mask.shape, np.uint16)
    shapes = Shapes(*_measure(mask, np.ascontiguousarray(grey), labels))
    return Silhouettes(shapes, labels, np.arange(-1, len(shapes)), grey)


def cleaned(mask: Grey, config: ComponentConfig) -> Grey:
    """Return a mask without specks, and with its narrow gaps closed if that is wanted."""
    for operation, side in (
        (cv2.MORPH_OPEN, config.opening_px),
        (cv2.MORPH_CLOSE, config.closing_px),
    ):
        if side > 1:
            mask = cv2.morphologyEx(mask, operation, np.ones((side, side), np.uint8))  # type: ignore[assignment]
    return mask


def shapes_of(column: NDArray[np.integer], row: NDArray[np.integer], value: Grey) -> Shapes:
    """Return one row: the shape of (n,) pixels with their grey values."""
    vector = np.zeros(SIZE)
    low = np.array([column.min(), row.min()], np.float64)
    extent = np.array([column.max(), row.max()]) + 1 - low
    vector[AREA] = len(value)
    vector[[WIDTH, HEIGHT]] = extent
    vector[HISTOGRAM] = np.bincount(value // (256 // BINS), minlength=BINS)
    vector[PLACE] = column.mean(), row.mean()
    return Shapes(vector[None], np.concatenate([low, extent])[None])


@compiled(types.UniTuple(types.f8[:, ::1], 2)(BYTES_2D, BYTES_2D, types.Array(types.u2, 2, 'C')))
def _measure(mask: Grey, grey: Grey, labels: NDArray[np.uint16]) -> tuple[Floats, Floats]:
    """Write the labels of components, and return their vectors and boxes."""
    runs = runs_of(mask)
    label, count = labels_of(runs)
    if count > MOST:
        return np.zeros((0, SIZE)), np.zeros((0, 4))
    vector, box = np.zeros((count, SIZE)), np.zeros((count, 4))
    box[:, :2] = 1e9
    for row in range(len(mask)):
        for run in range(runs.row[row], runs.row[row + 1]):
            first, end = runs.first[run], runs.last[run]
            one, edge = vector[label[run]], box[label[run]]
            one[AREA] += end - first
            for column in range(first, end):
                labels[row, column] = label[run] + 1
                one[3 + grey[row, column] // (256 // BINS)] += 1.0
                one[3 + BINS] += column
                one[4 + BINS] += row
            edge[0], edge[1] = min(edge[0], first), min(edge[1], row)
            edge[2], edge[3] = max(edge[2], end), max(edge[3], row + 1.0)
    for index in range(count):
        box[index, 2:] -= box[index, :2]
        vector[index, WIDTH:3] = box[index, 2:]
        vector[index, SIZE - 2 :] /= vector[index, AREA]
    return vector, box
