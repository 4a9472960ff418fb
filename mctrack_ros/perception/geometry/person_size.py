"""Apparent size and slant of an upright metre: a table over the image."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, compiled, inner
from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.geometry.overhead_view import TALL_M, seen_from_above

Floats = NDArray[np.float64]
STEP_PX = 4
TALLEST = 1.15  # height of one person at most, in usual heights
THICKNESS = 0.29
"""How far a body reaches along the ground, as a share of its height: what makes it appear taller
from above."""
ALLOWED = 0.25
"""Share by which it may appear taller before that counts: bodies differ by as much."""
ROUNDS, OF_THE_WAY = 8, 0.45
"""Foot points seen from above are found in so many steps, each so far to where the last one leads:
where the body looks twice as long as it is away, whole steps would lead to and fro."""


class SizeTable:
    """
    Size of an upright metre whose foot is at a pixel.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.

    Attributes
    ----------
    table : (r, c, 4) float64 array
        Every `STEP_PX` pixels: pixels, across and upright, of a metre, and, as shares of the
        latter, how far the upright leans to the right and the body reaches below its foot point
        (0, but where it is seen from above).

    """

    def __init__(self, mapping: GroundMapping) -> None:
        width, height = mapping.image_size
        column, row = np.meshgrid(
            np.arange(0, width + STEP_PX, STEP_PX), np.arange(0, height + STEP_PX, STEP_PX)
        )
        position = mapping.ground_from_image(np.column_stack([column.ravel(), row.ravel()]))
        across = mapping.width_px(position, 1.0)
        upright = _seen_height(mapping, position)
        slant = mapping.image_from_ground(position, 1.0)[:, 0] - column.ravel()
        table = np.column_stack([across, upright, slant / upright, np.zeros(len(position))])
        metre, share = seen_from_above(mapping, position)
        from_above = share > 0.0
        table[from_above] += (share[:, None] * (metre - table))[from_above]
        self.table = table.reshape(*column.shape, 4)

    def per_metre(self, foot: Floats) -> Floats:
        """
        Return (n, 2) px, across and upright, of a metre at (n, 2) foot points, px.

        Beyond the image its edge counts; above the horizon it is NaN.
        """
        return self._at(foot)[:, :2]

    def foot_of(self, box: Floats) -> Floats:
        """
        Return the (n, 2) foot points, px, of (n, 4) boxes.

        The bottom centre (event-tracking paper, eq. (2)), moved by half of what the upright leans
        over the box's height: beside the image's middle, head and foot are not in one column.
        Seen from above, the point of which a body of that height fills the box.
        """
        return _feet(self.table, np.ascontiguousarray(box, np.float64))

    def box_of(self, foot: Floats, extent: Floats) -> Floats:
        """Return the (n, 4) boxes, px, of (n, 2) or (1, 2) sizes, m, at (n, 2) foot points."""
        extent = np.ascontiguousarray(extent, np.float64)
        return _boxes(self.table, np.ascontiguousarray(foot, np.float64), extent)

    def _at(self, foot: Floats) -> Floats:
        """Return the (n, 4) rows of the table at (n, 2) foot points, px."""
        return _metres(self.table, np.ascontiguousarray(foot, np.float64))


def _seen_height(mapping: GroundMapping, position: Floats) -> Floats:
    """
    Return how many rows, (n,) px, a body of one metre spans at (n, 2) places.

    An upright metre, and the steeper a camera looks down the more of the body's thickness.
    """
    rows = mapping.height_px(position, 1.0)
    whole = np.abs(mapping.height_px(position, TALL_M)) / TALL_M
    along = np.hypot(*mapping.image_jacobian(position)[:, 1].T)
    return np.asarray(np.fmax(rows, (1.0 - ALLOWED) * whole + THICKNESS * along))


@inner
def metre_at(table: Floats, x: float, y: float) -> Floats:
    """Return the row of `SizeTable.table` that counts at a pixel, in compiled functions."""
    row = int(max(np.fmin(y / STEP_PX + 0.5, table.shape[0] - 1), 0))
    column = int(max(np.fmin(x / STEP_PX + 0.5, table.shape[1] - 1), 0))
    found: Floats = table[row, column]
    return found


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D))
def _metres(table: Floats, foot: Floats) -> Floats:
    found = np.empty((len(foot), table.shape[2]))
    for index in range(len(foot)):
        metre = metre_at(table, foot[index, 0], foot[index, 1])
        for column in range(len(metre)):
            found[index, column] = metre[column]
    return found


@inner
def foot_below(
    table: Floats, left: float, top: float, width: float, height: float
) -> tuple[float, float]:
    """Return the foot point, px, of a box in compiled functions."""
    middle, bottom = left + width / 2, top + height
    x, y = middle, top + height / 2
    if metre_at(table, middle, bottom)[3] == 0.0 and metre_at(table, x, y)[3] == 0.0:
        return middle - metre_at(table, middle, bottom)[2] * height / 2, bottom
    for _ in range(ROUNDS):
        metre = metre_at(table, x, y)
        x += OF_THE_WAY * (middle - metre[2] * height / 2 - x)
        y += OF_THE_WAY * (bottom - metre[3] * height - y)
    return x, y


@inner
def box_at(table: Floats, foot: Floats, extent: Floats, box: Floats) -> None:
    """Write the box, (4,), of a size, (2,) m, at a foot point, (2,) px."""
    across, upright, lean, below = metre_at(table, foot[0], foot[1])
    width, height = extent[0] * across, extent[1] * upright
    box[0] = foot[0] - width / 2 + lean * height / 2
    box[1] = foot[1] - height + below * height
    box[2], box[3] = width, height


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D))
def _feet(table: Floats, box: Floats) -> Floats:
    foot = np.empty((len(box), 2))
    for index in range(len(box)):
        left, top, width, height = box[index]
        foot[index, 0], foot[index, 1] = foot_below(table, left, top, width, height)
    return foot


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D, FLOATS_2D))
def _boxes(table: Floats, foot: Floats, extent: Floats) -> Floats:
    """Return boxes of sizes at feet, one size for all or one each."""
    box = np.empty((len(foot), 4))
    for index in range(len(foot)):
        box_at(table, foot[index], extent[index if len(extent) > 1 else 0], box[index])
    return box
