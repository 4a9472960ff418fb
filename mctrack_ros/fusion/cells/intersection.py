"""Covariance intersection: estimates whose errors have an unknown part in common, combined."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def intersection(
    mean: Floats, covariance: Floats, part: Indices, parts: int
) -> tuple[Floats, Floats]:
    """
    Combine the estimates of each target by covariance intersection.

    The inverse of the result's covariance is a convex combination of the inverses of theirs. So it
    is never too small, whatever their errors share: cells see a target with the same cameras'
    bias, or took over its state from each other (Julier and Uhlmann 1997, "A non-divergent
    estimation algorithm in the presence of unknown correlations"). The weights are inverse to the
    traces of the places' covariances (Niehsen 2002, "Information fusion based on fast covariance
    intersection filtering"): nothing is searched for. One estimate alone is returned as it is.

    Parameters
    ----------
    mean : (m, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (m, 4, 4) array
        Positive definite.
    part : (m,) int array
        Which target each is of.
    parts : int
        How many targets there are, each with one estimate at least.

    Returns
    -------
    mean : (parts, 4) array
    covariance : (parts, 4, 4) array

    """
    weight = 1.0 / np.trace(covariance[:, :2, :2], axis1=1, axis2=2)
    weight /= np.bincount(part, weight, parts)[part]
    information = np.linalg.inv(covariance) * weight[:, None, None]
    total, pull = np.zeros((parts, 4, 4)), np.zeros((parts, 4))
    np.add.at(total, part, information)
    np.add.at(pull, part, (information @ mean[:, :, None])[:, :, 0])
    combined = np.linalg.inv(total)
    return (combined @ pull[:, :, None])[:, :, 0], (combined + combined.swapaxes(1, 2)) / 2
