"""People drawn one by one and laid over one another: who hides whom, to the pixel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_SHIFT = 4
_TOUCHING = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class Silhouette:
    """
    One person as drawn alone.

    Attributes
    ----------
    left, top : int
        Where the patch lies in the image, px.
    cloth : (height, width) uint8 array
        What each pixel is made of; 0: not the person. Cut at the image's edges.
    truncated : bool
        Whether the image's edge cut something off.

    """

    left: int
    top: int
    cloth: Pixels
    truncated: bool

    @property
    def box(self) -> tuple[int, int, int, int]:
        """Return left, top, width and height of the tight box, px."""
        return self.left, self.top, self.cloth.shape[1], self.cloth.shape[0]

    @property
    def window(self) -> tuple[slice, slice]:
        """Return the rows and columns of the image that the patch covers."""
        height, width = self.cloth.shape
        return slice(self.top, self.top + height), slice(self.left, self.left + width)


def drawn_alone(
    corners: Floats, order: NDArray[np.int64], cloth: NDArray[np.int64], size: tuple[int, int]
) -> Silhouette | None:
    """
    Draw one person.

    Parameters
    ----------
    corners : (limbs, 4, 2) array
        Corners of the limbs, px.
    order : (limbs,) int array
        Limbs from far to near.
    cloth : (limbs,) int array
        What each limb is made of.
    size : (int, int)
        Width and height of the image, px.

    Returns
    -------
    Silhouette or None
        Cut to the image and to its pixels; None where nothing of it is in the image.

    """
    low = np.floor(corners.min(axis=(0, 1))).astype(np.int64) - 1
    high = np.ceil(corners.max(axis=(0, 1))).astype(np.int64) + 2
    if (high <= 0).any() or (low >= size).any():
        return None
    width, height = (high - low).tolist()
    patch = np.zeros((height, width), np.uint8)
    fixed = np.round((corners - low - 0.5) * (1 << _SHIFT)).astype(np.int32)
    for limb in order.tolist():
        cv2.fillConvexPoly(patch, fixed[limb], int(cloth[limb]), cv2.LINE_8, _SHIFT)
    cut_low, cut_high = np.maximum(-low, 0), np.minimum(size - low, [width, height])
    inside = patch[cut_low[1] : cut_high[1], cut_low[0] : cut_high[0]]
    left, top, wide, tall = cv2.boundingRect(inside)
    if wide == 0:
        return None
    truncated = bool(np.count_nonzero(patch) > np.count_nonzero(inside))
    origin = low + cut_low
    shape = np.ascontiguousarray(inside[top : top + tall, left : left + wide])
    return Silhouette(int(origin[0]) + left, int(origin[1]) + top, shape, truncated)


def touching_pairs(shapes: list[Silhouette]) -> NDArray[np.int64]:
    """Return the (pairs, 2) indices of silhouettes that overlap or are neighbours to the pixel."""
    boxes = np.array([shape.box for shape in shapes], np.int64).reshape(-1, 4)
    low, high = boxes[:, :2], boxes[:, :2] + boxes[:, 2:]
    near = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
    candidates = np.argwhere(np.triu(near, 1))
    kept = [_touch(shapes[one], shapes[other]) for one, other in candidates.tolist()]
    return candidates[np.array(kept, np.bool_)]


def _touch(one: Silhouette, other: Silhouette) -> bool:
    """Return whether two silhouettes whose boxes do, overlap or are neighbours."""
    rows = _common(one.top, one.cloth.shape[0], other.top, other.cloth.shape[0])
    columns = _common(one.left, one.cloth.shape[1], other.left, other.cloth.shape[1])
    first, second = (
        _window(shape, rows, columns, margin) for shape, margin in ((one, 1), (other, 0))
    )
    grown = cv2.dilate(first, _TOUCHING)[1:-1, 1:-1]
    return bool(np.logical_and(grown, second).any())


def _common(start: int, length: int, other_start: int, other_length: int) -> tuple[int, int]:
    """Return the range that two intervals share when each grows by one."""
    low = max(start, other_start) - 1
    return low, min(start + length, other_start + other_length) + 1


def _window(
    shape: Silhouette, rows: tuple[int, int], columns: tuple[int, int], margin: int
) -> Pixels:
    """Return a window of the image, grown by a margin, with one person's pixels in it."""
    top, bottom = rows[0] - margin, rows[1] + margin
    left, right = columns[0] - margin, columns[1] + margin
    height, width = shape.cloth.shape
    out = np.zeros((bottom - top, right - left), np.uint8)
    first_row, last_row = max(top, shape.top), min(bottom, shape.top + height)
    first_column, last_column = max(left, shape.left), min(right, shape.left + width)
    if first_row < last_row and first_column < last_column:
        out[first_row - top : last_row - top, first_column - left : last_column - left] = (
            shape.cloth[
                first_row - shape.top : last_row - shape.top,
                first_column - shape.left : last_column - shape.left,
            ]
        )
    return out
