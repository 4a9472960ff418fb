"""Which detections can be used at all."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled
from mctrack_ros.interfaces import Detections

LARGEST_VARIANCE = 1e6
"""A detection less certain than this says nothing, m²."""


def usable_rows(detections: Detections) -> NDArray[np.bool_]:
    """
    Tell which detections, (n,), have a finite position and a sound covariance.

    A covariance is sound if it is finite, symmetric enough to be positive definite, and not
    larger than a square kilometre.
    """
    covariance = np.ascontiguousarray(detections.covariance)
    return _usable(covariance, np.ascontiguousarray(detections.position))


@compiled(
    types.b1[::1](
        types.Array(types.f4, 3, 'C', readonly=True), types.Array(types.f4, 2, 'C', readonly=True)
    )
)
def _usable(covariance: NDArray[np.float32], position: NDArray[np.float32]) -> NDArray[np.bool_]:
    usable = np.empty(len(position), np.bool_)
    for row in range(len(position)):
        xx, yy = np.float64(covariance[row, 0, 0]), np.float64(covariance[row, 1, 1])
        xy = (np.float64(covariance[row, 0, 1]) + np.float64(covariance[row, 1, 0])) / 2
        sound = xx > 0 and yy > 0 and xx * yy > xy * xy
        sound = sound and xx < LARGEST_VARIANCE and yy < LARGEST_VARIANCE
        known = np.isfinite(position[row, 0]) and np.isfinite(position[row, 1])
        usable[row] = sound and known
    return usable
