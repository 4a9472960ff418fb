"""Which rows of feedback can be targets at all: hostile or broken ones could end a camera node."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled
from mctrack_ros.interfaces import (
    LARGEST_DISTANCE,
    LARGEST_EXTENT,
    LARGEST_SPEED,
    LARGEST_VARIANCE,
    Feedback,
)

Singles = NDArray[np.float32]

FULL = 1.001
"""A bin of a template, which is a share, is no more, but for rounding."""
_SINGLES_2D = types.Array(types.f4, 2, 'C', readonly=True)
_SINGLES_3D = types.Array(types.f4, 3, 'C', readonly=True)


def is_sound(feedback: Feedback) -> NDArray[np.bool_]:
    """
    Tell which rows, (n,), can be targets: places, speeds, sizes and colours that are possible.

    Positions and velocities are bounded, no two components of the state are correlated by 1 or
    more, sizes are above 0 where they are known, bins of templates from 0 to 1.
    """
    columns = feedback.position, feedback.velocity, feedback.covariance
    return _is_sound(*columns, feedback.extent, feedback.template)


@compiled(types.b1[::1](_SINGLES_2D, _SINGLES_2D, _SINGLES_3D, _SINGLES_2D, _SINGLES_2D))
def _is_sound(
    position: Singles, velocity: Singles, covariance: Singles, extent: Singles, template: Singles
) -> NDArray[np.bool_]:
    sound = np.ones(len(position), np.bool_)
    for row in range(len(position)):
        for axis in range(2):
            size = extent[row, axis]
            sound[row] &= abs(position[row, axis]) < LARGEST_DISTANCE
            sound[row] &= abs(velocity[row, axis]) < LARGEST_SPEED
            sound[row] &= np.isnan(size) or 0.0 < size < LARGEST_EXTENT
        for one in range(4):
            own = np.float64(covariance[row, one, one])
            sound[row] &= 0.0 < own < LARGEST_VARIANCE
            for other in range(one + 1, 4):
                mixed = np.float64(covariance[row, one, other])
                sound[row] &= mixed * mixed < own * np.float64(covariance[row, other, other])
        for share in template[row]:
            sound[row] &= 0.0 <= share <= FULL
    return sound
