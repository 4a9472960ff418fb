"""How much ground a vehicle covers, away from the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.geometry.person_size import SizeTable

Floats = NDArray[np.float64]

ROUNDS = 4  # of height from foot and foot from height


def ground_depth(
    box: Floats, height_m: Floats | float, sizes: SizeTable, mapping: GroundMapping
) -> Floats:
    """
    Return how far the ground that vehicles cover reaches from their near ends.

    A person stands at the bottom centre of the box. A vehicle covers ground: from there back to
    the point below the far edge of its roof.

    Parameters
    ----------
    box : (n, 4) array
        Left, top, width, height, px.
    height_m : (n,) array or float
        Of the vehicles, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    Returns
    -------
    (n, 2) array
        From the near end to the far one, m; 0 where that is above the horizon.

    """
    top = box[:, :2] + box[:, 2:] * [0.5, 0.0]
    foot, bottom = top.copy(), box[:, 1] + box[:, 3]
    for _ in range(ROUNDS):
        height = sizes.per_metre(foot)[:, 1] * height_m
        foot[:, 1] = np.fmin(top[:, 1] + height, bottom)
    reach = mapping.ground_from_image(foot) - mapping.ground_from_image(sizes.foot_of(box))
    return np.where(np.isfinite(reach), reach, 0.0)


def depth_covariance(depth: Floats) -> Floats:
    """Return the (n, 2, 2) covariance, m², of a uniform distribution along (n, 2) depths, m."""
    return depth[:, :, None] * depth[:, None] / 12
