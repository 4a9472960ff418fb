"""Which detections can be used at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections

LARGEST_VARIANCE = 1e6
"""A detection less certain than this says nothing, m²."""


def usable_rows(detections: Detections) -> NDArray[np.bool_]:
    """
    Tell which detections, (n,), have a finite position and a sound covariance.

    A covariance is sound if it is finite, symmetric enough to be positive definite, and not
    larger than a square kilometre.
    """
    covariance = detections.covariance.astype(np.float64)
    xx, yy = covariance[:, 0, 0], covariance[:, 1, 1]
    xy = (covariance[:, 0, 1] + covariance[:, 1, 0]) / 2
    with np.errstate(invalid='ignore', over='ignore'):
        sound = (xx > 0) & (yy > 0) & (xx * yy > xy * xy)
        sound &= (xx < LARGEST_VARIANCE) & (yy < LARGEST_VARIANCE)
    return sound & np.isfinite(detections.position[:, :2]).all(axis=1)
