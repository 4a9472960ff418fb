"""How large and how slanted an upright metre looks where: a table over the picture."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, compiled, inner
from mctrack_ros.ground import GroundMapping

Floats = NDArray[np.float64]
STEP_PX = 4
TALLEST = 1.15  # height of one person at most, in usual heights
THICKNESS = 0.29
"""How far a body reaches along the ground, as a share of its height: what makes it look taller
from above."""
ALLOWED = 0.25
"""By so much, as a share, it may look taller before that counts: so much bodies differ."""
USUAL_M = 1.75
"""The head of somebody so tall is nearer to a camera above him than his feet, and looks larger."""


class SizeTable:
    """
    Size of an upright metre whose foot is at a pixel.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.

    Attributes
    ----------
    table : (r, c, 3) float64 array
        Every `STEP_PX` pixels: pixels, across and upright, of a metre, and how far the upright
        leans to the right, as a share of the latter.

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
        self.table = np.column_stack([across, upright, slant / upright])
        self.table = self.table.reshape(*column.shape, 3)

    def per_metre(self, foot: Floats) -> Floats:
        """
        Return (n, 2) px, across and upright, of a metre at (n, 2) foot points, px.

        Beyond the picture its edge counts; above the horizon it is NaN.
        """
        return self._at(foot)[:, :2]

    def foot_of(self, box: Floats) -> Floats:
        """
        Return the (n, 2) foot points, px, of (n, 4) boxes.

        The bottom centre (event-tracking paper, eq. (2)), moved by half of what the upright leans
        over the box's height: beside the picture's middle, head and foot are not in one column.
        """
        return _feet(self.table, np.ascontiguousarray(box, np.float64))

    def box_of(self, foot: Floats, extent: Floats) -> Floats:
        """Return the (n, 4) boxes, px, of (n, 2) or (1, 2) sizes, m, at (n, 2) foot points."""
        extent = np.ascontiguousarray(extent, np.float64)
        return _boxes(self.table, np.ascontiguousarray(foot, np.float64), extent)

    def _at(self, foot: Floats) -> Floats:
        """Return the (n, 3) rows of the table at (n, 2) foot points, px."""
        return _metres(self.table, np.ascontiguousarray(foot, np.float64))


def _seen_height(mapping: GroundMapping, position: Floats) -> Floats:
    """
    Return how many rows, (n,) px, a body of one metre spans at (n, 2) places.

    An upright metre, and the steeper a camera looks down the more of the body's thickness.
    """
    rows = mapping.height_px(position, 1.0)
    whole = np.abs(mapping.height_px(position, USUAL_M)) / USUAL_M
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
    found = np.empty((len(foot), 3))
    for index in range(len(foot)):
        found[index] = metre_at(table, foot[index, 0], foot[index, 1])
    return found


@inner
def foot_below(table: Floats, box: Floats) -> tuple[float, float]:
    """Return the foot point, px, of a box, (4,), in compiled functions."""
    left, top, width, height = box
    x, y = left + width / 2, top + height
    return x - metre_at(table, x, y)[2] * height / 2, y


@inner
def box_at(table: Floats, foot: Floats, extent: Floats, box: Floats) -> None:
    """Write the box, (4,), of a size, (2,) m, at a foot point, (2,) px."""
    across, upright, lean = metre_at(table, foot[0], foot[1])
    width, height = extent[0] * across, extent[1] * upright
    box[0] = foot[0] - width / 2 + lean * height / 2
    box[1] = foot[1] - height
    box[2], box[3] = width, height


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D))
def _feet(table: Floats, box: Floats) -> Floats:
    foot = np.empty((len(box), 2))
    for index in range(len(box)):
        foot[index, 0], foot[index, 1] = foot_below(table, box[index])
    return foot


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D, FLOATS_2D))
def _boxes(table: Floats, foot: Floats, extent: Floats) -> Floats:
    """Return boxes of sizes at feet, one size for all or one each."""
    box = np.empty((len(foot), 4))
    for index in range(len(foot)):
        box_at(table, foot[index], extent[index if len(extent) > 1 else 0], box[index])
    return box
