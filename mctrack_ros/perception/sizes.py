"""How many pixels a metre is where: a table over the picture, for speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import ProjectiveMapping

Floats = NDArray[np.float64]
STEP_PX = 4


class SizeTable:
    """
    Size of an upright metre whose foot is at a pixel.

    Parameters
    ----------
    mapping : ProjectiveMapping
        Of the camera.

    """

    def __init__(self, mapping: ProjectiveMapping) -> None:
        width, height = mapping.image_size
        column, row = np.meshgrid(
            np.arange(0, width + STEP_PX, STEP_PX), np.arange(0, height + STEP_PX, STEP_PX)
        )
        position = mapping.ground_from_image(np.column_stack([column.ravel(), row.ravel()]))
        across = mapping.width_px(position, 1.0)
        upright = mapping.height_px(position, 1.0)
        self._table = np.column_stack([across, upright]).reshape(*column.shape, 2)

    def per_metre(self, foot: Floats) -> Floats:
        """
        Return (n, 2) px, across and upright, of a metre at (n, 2) foot points, px.

        Beyond the picture its edge counts; above the horizon it is NaN.
        """
        last = np.array(self._table.shape[1::-1]) - 1
        cell = np.fmax(np.fmin(foot / STEP_PX + 0.5, last), 0).astype(np.intp)
        found: Floats = self._table[cell[:, 1], cell[:, 0]]
        return found
