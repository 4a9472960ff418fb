"""From the foreground mask to silhouettes: opening, connected components, features."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, INTS_2D, compiled, inner
from mctrack_ros.config import parameter
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
        """Refuse kernels that would shift what they clean."""
        for name in ('opening_px', 'closing_px'):
            if getattr(self, name) % 2 == 0:
                raise ValueError(f'{name} is {getattr(self, name)}, expected an odd number')


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
    Open a mask and collect its 4-connected components.

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
    runs = _runs(mask)
    count = int(runs[:, 3].max(initial=0))
    if count > MOST:
        count, runs = 0, runs[:0]
    labels = np.zeros(mask.shape, np.uint16)
    shapes = Shapes(*_measure(runs, np.ascontiguousarray(grey), labels, count))
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


@inner
def _root(parent: Ints, run: int) -> int:
    while parent[run] != run:
        parent[run] = parent[parent[run]]
        run = parent[run]
    return run


@compiled(types.i8[:, ::1](BYTES_2D))
def _runs(mask: Grey) -> Ints:
    """
    Return the (n, 4) runs of foreground, row by row: row, first and last column, component.

    Runs that share a column with one in the row above are of one component (4-connected).
    Components count from 1 in the order of their first runs. OpenCV's labels of all pixels cost
    three times as much.
    """
    height, width = mask.shape
    runs = np.empty((height * (width // 2 + 1), 4), np.int64)
    parent = np.empty(len(runs), np.int64)
    count, above, row_start = 0, 0, 0
    for row in range(height):
        above_end, above, row_start = count, row_start, count
        column = 0
        while column < width:
            if mask[row, column] == 0:
                column += 1
                continue
            first = column
            while column < width and mask[row, column] != 0:
                column += 1
            runs[count, 0], runs[count, 1], runs[count, 2] = row, first, column - 1
            parent[count] = count
            while above < above_end and runs[above, 2] < first:
                above += 1
            other = above
            while other < above_end and runs[other, 1] < column:
                one, two = _root(parent, count), _root(parent, other)
                parent[max(one, two)] = min(one, two)
                other += 1
            count += 1
    components = 0
    for run in range(count):
        if parent[run] == run:
            components += 1
            runs[run, 3] = components
        else:
            runs[run, 3] = runs[_root(parent, run), 3]
    return runs[:count].copy()


@compiled(
    types.UniTuple(types.f8[:, ::1], 2)(INTS_2D, BYTES_2D, types.Array(types.u2, 2, 'C'), types.i8)
)
def _measure(
    runs: Ints, grey: Grey, labels: NDArray[np.uint16], count: int
) -> tuple[Floats, Floats]:
    """Write the labels of runs, and return the vectors and boxes of components."""
    vector, box = np.zeros((count, SIZE)), np.zeros((count, 4))
    box[:, :2] = 1e9
    for run in range(len(runs)):
        row, first, last, label = runs[run]
        one, edge = vector[label - 1], box[label - 1]
        one[AREA] += last - first + 1
        for column in range(first, last + 1):
            labels[row, column] = label
            one[3 + grey[row, column] // (256 // BINS)] += 1.0
            one[3 + BINS] += column
            one[4 + BINS] += row
        edge[0], edge[1] = min(edge[0], first), min(edge[1], row)
        edge[2], edge[3] = max(edge[2], last + 1.0), max(edge[3], row + 1.0)
    for index in range(count):
        box[index, 2:] -= box[index, :2]
        vector[index, WIDTH:3] = box[index, 2:]
        vector[index, SIZE - 2 :] /= max(vector[index, AREA], 1.0)
    return vector, box
