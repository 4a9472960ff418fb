"""A local origin: large coordinates become small ones, so that no digits are lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
STEP_M = 1000.0
"""Local origins lie on whole multiples of this: coordinates about them are exact."""


def local_origin(points: ArrayLike) -> Floats:
    """
    Return the origin, (2,) m, to compute with some points about: near their middle, in whole km.

    Least squares, areas and rotations lose digits with the square of the distance from the
    origin; within half a kilometre of zero, and for no or infinite points, it is zero.

    Parameters
    ----------
    points : (n, 2) array_like
        On the ground, m.

    """
    places = np.asarray(points, np.float64).reshape(-1, 2)
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        return np.zeros(2)
    origin: Floats = np.round(np.median(places, axis=0) / STEP_M) * STEP_M + 0.0
    return origin
