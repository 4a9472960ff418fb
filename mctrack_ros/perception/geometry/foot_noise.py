"""Noise of foot points: the default model, and its adaptation to each track; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, INTS_1D, compiled, inner

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OUTLIER = 9.0
"""Squared innovations are clipped at this many innovation variances."""


@inner
def foot_variance(height_px: float, same_px: float, share: float) -> float:
    """Return the variance, px², of one foot point along each axis; see `foot_noise`."""
    return (same_px + share * height_px) ** 2


@compiled(types.f8[:, :, ::1](FLOATS_2D, types.f8, types.f8))
def foot_noise(box: Floats, same_px: float, share: float) -> Floats:
    """
    Return the (n, 2, 2) covariance, px², of foot points by the default model.

    Parameters
    ----------
    box : (n, 4) array
        Boxes, px.
    same_px, share : float
        Standard deviation: part that is the same for all, px, and part that grows with the box,
        as a share of its height.

    """
    noise = np.zeros((len(box), 2, 2))
    for row in range(len(box)):
        noise[row, 0, 0] = noise[row, 1, 1] = foot_variance(box[row, 3], same_px, share)
    return noise


@compiled(
    types.void(types.f8[:, ::1], INTS_1D, FLOATS_2D, FLOATS_2D, FLOATS_3D, FLOATS_3D, types.f8)
)
def follow_noise(
    ratio: Floats, rows: Ints, foot: Floats, expected: Floats, noise: Floats, spread: Floats,
    pace: float,
) -> None:  # fmt: skip
    """
    Adapt the measurement noise of tracks to their innovations.

    Noise is the squared innovation minus the predicted variance (event-tracking paper, section
    3.2 and Figure 5). The estimate never falls below the default: errors of a foot point last
    from image to image, so small scatter does not prove a small error.

    Parameters
    ----------
    ratio : (t, 2) array
        Variance of each track's foot points over the default, along x and y of the image, at
        least 1; changed in place.
    rows : (n,) int64 array
        Track of each foot point; -1: it is not used.
    foot : (n, 2) array
        Measured, px.
    expected : (t, 2) array
        Foot points of the tracks, predicted, px.
    noise : (n, 2, 2) array
        Covariance assumed of those measured, px².
    spread : (t, 2, 2) array
        Covariance of those predicted, px².
    pace : float
        Filter gain, 0 to 1.

    """
    for row, track in enumerate(rows):
        if track < 0:
            continue
        for axis in range(2):
            innovation = foot[row, axis] - expected[track, axis]
            variance, predicted = noise[row, axis, axis], spread[track, axis, axis]
            square = min(innovation**2, OUTLIER * (variance + predicted))
            usual = variance / ratio[track, axis]
            change = pace * ((square - predicted) / usual - ratio[track, axis])
            if np.isfinite(change):
                ratio[track, axis] = max(ratio[track, axis] + change, 1.0)
