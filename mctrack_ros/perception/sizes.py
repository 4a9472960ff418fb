"""How large and how slanted an upright metre looks where: a table over the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.compiled import inner
from mctrack_ros.ground import ProjectiveMapping

Floats = NDArray[np.float64]
STEP_PX = 4
TALLEST = 1.15  # height of one person at most, in usual heights


class SizeTable:
    """
    Size of an upright metre whose foot is at a pixel.

    Parameters
    ----------
    mapping : ProjectiveMapping
        Of the camera.

    Attributes
    ----------
    table : (r, c, 3) float64 array
        Every `STEP_PX` pixels: pixels, across and upright, of a metre, and how far the upright
        leans to the right, as a share of its height.

    """

    def __init__(self, mapping: ProjectiveMapping) -> None:
        width, height = mapping.image_size
        column, row = np.meshgrid(
            np.arange(0, width + STEP_PX, STEP_PX), np.arange(0, height + STEP_PX, STEP_PX)
        )
        position = mapping.ground_from_image(np.column_stack([column.ravel(), row.ravel()]))
        across = mapping.width_px(position, 1.0)
        upright = mapping.height_px(position, 1.0)
        slant = mapping.image_from_ground(position, 1.0)[:, 0] - column.ravel()
        self.table = np.column_stack([across, upright, slant / upright])
        self.table = self.table.reshape(*column.shape, 3)

    def per_metre(self, foot: Floats) -> Floats:
        """
        Return (n, 2) px, across and upright, of a metre at (n, 2) foot points, px.

        Beyond the picture its edge counts; above the horizon it is NaN.
        """
        cell = self._cell(foot)
        found: Floats = self.table[cell[:, 1], cell[:, 0], :2]
        return found

    def foot_of(self, box: Floats) -> Floats:
        """
        Return the (n, 2) foot points, px, of (n, 4) boxes.

        The bottom centre (event-tracking paper, eq. (2)), moved by half of what the upright leans
        over the box's height: beside the picture's middle, head and foot are not in one column.
        """
        bottom = np.column_stack([box[:, 0] + box[:, 2] / 2, box[:, 1] + box[:, 3]])
        bottom[:, 0] -= self._lean(bottom) * box[:, 3] / 2
        return bottom

    def box_of(self, foot: Floats, extent: Floats) -> Floats:
        """Return the (n, 4) boxes, px, of (n, 2) widths and heights, m, at foot points."""
        size = extent * self.per_metre(foot)
        left = foot[:, 0] - size[:, 0] / 2 + self._lean(foot) * size[:, 1] / 2
        return np.column_stack([left, foot[:, 1] - size[:, 1], size])

    def _lean(self, foot: Floats) -> Floats:
        cell = self._cell(foot)
        lean: Floats = self.table[cell[:, 1], cell[:, 0], 2]
        return lean

    def _cell(self, foot: Floats) -> NDArray[np.intp]:
        last = np.array(self.table.shape[1::-1]) - 1
        cell: NDArray[np.intp] = np.fmax(np.fmin(foot / STEP_PX + 0.5, last), 0).astype(np.intp)
        return cell


@inner
def metre_at(table: Floats, x: float, y: float) -> Floats:
    """Return the row of `SizeTable.table` that counts at a pixel, in compiled functions."""
    row = min(max(int(y / STEP_PX + 0.5), 0), table.shape[0] - 1)
    column = min(max(int(x / STEP_PX + 0.5), 0), table.shape[1] - 1)
    found: Floats = table[row, column]
    return found
