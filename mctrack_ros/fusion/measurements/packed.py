"""What detections measure, packed: the numbers of one lie side by side in memory."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_2D, COLUMN_3D, INTS_1D, compiled, inner

Floats = NDArray[np.float64]

X, Y, XX, XY, YY, OF_XX, OF_XY, OF_YY = range(8)
"""Columns: the place, m, its covariance, m², and the information, the inverse of that, 1/m²."""


@inner
def inverted(xx: float, xy: float, yy: float) -> tuple[float, float, float]:
    """Return the inverse of a symmetric (2, 2) matrix, infinite where there is none."""
    determinant = xx * yy - xy * xy
    scale = 1.0 / determinant if determinant != 0.0 else np.inf
    return yy * scale, -xy * scale, xx * scale


@compiled(types.f8[:, ::1](COLUMN_2D, COLUMN_3D, INTS_1D))
def measured(position: Floats, noise: Floats, rows: NDArray[np.int64]) -> Floats:
    """
    Pack what some detections measure.

    Parameters
    ----------
    position, noise : (m, 2), (m, 2, 2) arrays
        Places and their covariances, symmetric, m and m².
    rows : (k,) int64 array
        Which ones.

    Returns
    -------
    (k, 8) array

    """
    packed = np.empty((len(rows), 8))
    for index, row in enumerate(rows):
        xx, xy, yy = noise[row, 0, 0], noise[row, 0, 1], noise[row, 1, 1]
        packed[index, X], packed[index, Y] = position[row, 0], position[row, 1]
        packed[index, XX], packed[index, XY], packed[index, YY] = xx, xy, yy
        xx, xy, yy = inverted(xx, xy, yy)
        packed[index, OF_XX], packed[index, OF_XY], packed[index, OF_YY] = xx, xy, yy
    return packed
