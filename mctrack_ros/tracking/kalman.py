"""Batched constant-velocity Kalman filter on the ground: state (x, y, vx, vy), SI units."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, FLOATS_3D, compiled, inner

Floats = NDArray[np.float64]
MEDIAN_SQUARED = 2 * np.log(2)
"""Median of a squared Mahalanobis distance in the plane."""
_STATES = types.Tuple([types.f8[:, ::1], types.f8[:, :, ::1]])


def transition_matrix(seconds: ArrayLike) -> Floats:
    """Return the (..., 4, 4) constant-velocity transitions over times (...), s."""
    seconds = np.asarray(seconds, np.float64)
    matrix = np.zeros((*seconds.shape, 4, 4))
    matrix[..., range(4), range(4)] = 1.0
    matrix[..., 0, 2] = matrix[..., 1, 3] = seconds
    return matrix


def position_matrix(seconds: ArrayLike = 0.0) -> Floats:
    """Return the (..., 2, 4) matrices from a state to its position some time later, s."""
    return transition_matrix(seconds)[..., :2, :]


def predict(
    mean: Floats, covariance: Floats, seconds: ArrayLike, acceleration_density: float
) -> tuple[Floats, Floats]:
    """
    Predict states forward.

    Parameters
    ----------
    mean : (n, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (n, 4, 4) array
        Their covariances.
    seconds : float or (n,) array_like
        How far, not negative, s.
    acceleration_density : float
        Power spectral density of the acceleration, m²/s³.

    Returns
    -------
    mean : (n, 4) array
    covariance : (n, 4, 4) array

    """
    each = np.empty(len(mean))
    each[:] = seconds
    return _predict(_array(mean), _array(covariance), each, float(acceleration_density))


def update(
    mean: Floats, covariance: Floats, innovation: Floats, noise: Floats, measurement_matrix: Floats
) -> tuple[Floats, Floats]:
    """
    Update states with one measurement each, in Joseph's form.

    Parameters
    ----------
    mean : (n, 4) array
        Predicted x, y, vx, vy; m and m/s.
    covariance : (n, 4, 4) array
        Their covariances.
    innovation : (n, 2) array
        Measured minus predicted, in the measurement's unit (m or px).
    noise : (n, 2, 2) array
        Covariance of the measurements.
    measurement_matrix : (2, 4) or (n, 2, 4) array
        Derivative of the measurement by the state.

    Returns
    -------
    mean : (n, 4) array
    covariance : (n, 4, 4) array

    """
    matrix = np.empty((len(mean), 2, 4))
    matrix[:] = measurement_matrix
    return updated(
        _array(mean), _array(covariance), _array(innovation), _array(noise), _array(matrix)
    )


def projected(covariance: Floats, slope: Floats) -> Floats:
    """Return the (n, 2, 2) covariances of what changes with the place by (n, 2, 2) slopes."""
    return projections(_array(covariance), _array(slope))


def inverse(matrix: Floats) -> Floats:
    """Return the inverses of (..., 2, 2) matrices."""
    return _inverses(_array(matrix).reshape(-1, 2, 2)).reshape(matrix.shape)


def symmetric(matrix: Floats) -> Floats:
    """Return matrices without the asymmetry that rounding leaves."""
    halved: Floats = (matrix + matrix.swapaxes(-1, -2)) / 2
    return halved


def _array(values: Floats) -> Floats:
    """Return values as compiled functions take them."""
    return np.ascontiguousarray(values, np.float64)


@inner
def inverted(matrix: Floats, inverse: Floats) -> None:
    """Write the inverse of a (2, 2) matrix, infinite where there is none; when compiled."""
    scale = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    scale = 1.0 / scale if scale != 0.0 else np.inf
    inverse[0, 0], inverse[1, 1] = matrix[1, 1] * scale, matrix[0, 0] * scale
    inverse[0, 1], inverse[1, 0] = -matrix[0, 1] * scale, -matrix[1, 0] * scale


@compiled(types.f8[:, :, ::1](FLOATS_3D))
def _inverses(matrix: Floats) -> Floats:
    inverses = np.empty(matrix.shape)
    for index in range(len(matrix)):
        inverted(matrix[index], inverses[index])
    return inverses


@compiled(types.f8[:, :, ::1](FLOATS_3D, FLOATS_3D))
def projections(covariance: Floats, slope: Floats) -> Floats:
    """Return what `projected` does; to be called by compiled functions, too."""
    spread = np.zeros(slope.shape)
    for n in range(len(slope)):
        for i in range(2):
            for j in range(2):
                for k in range(2):
                    for m in range(2):
                        spread[n, i, j] += slope[n, i, k] * covariance[n, k, m] * slope[n, j, m]
    return spread


@inner
def moved_on(
    mean: Floats, old: Floats, time: float, density: float, moved: Floats, new: Floats
) -> None:
    """Write one state (4,), (4, 4) as `predict` does: with white acceleration, integrated."""
    for i in range(2):
        moved[i] = mean[i] + time * mean[2 + i]
        moved[2 + i] = mean[2 + i]
        for j in range(2):
            mixed, velocity = (old[i, 2 + j] + old[2 + j, i]) / 2, old[2 + i, 2 + j]
            other = (old[j, 2 + i] + old[2 + i, j]) / 2
            new[i, j] = old[i, j] + time * (mixed + other) + time**2 * velocity
            new[i, 2 + j] = new[2 + j, i] = mixed + time * velocity
            new[2 + i, 2 + j] = velocity
        new[i, i] += density * time**3 / 3
        new[i, 2 + i] += density * time**2 / 2
        new[2 + i, i] = new[i, 2 + i]
        new[2 + i, 2 + i] += density * time


@compiled(_STATES(FLOATS_2D, FLOATS_3D, FLOATS_1D, types.f8))
def _predict(
    mean: Floats, covariance: Floats, seconds: Floats, density: float
) -> tuple[Floats, Floats]:
    """Apply `transition_matrix` and add white acceleration, block by block."""
    moved, spread = np.empty(mean.shape), np.empty(covariance.shape)
    for index in range(len(mean)):
        moved_on(
            mean[index], covariance[index], seconds[index], density, moved[index], spread[index]
        )
    return moved, spread


@compiled(_STATES(FLOATS_2D, FLOATS_3D, FLOATS_2D, FLOATS_3D, FLOATS_3D))
def updated(
    mean: Floats, covariance: Floats, innovation: Floats, noise: Floats, matrix: Floats
) -> tuple[Floats, Floats]:
    """Return what `update` does, one state after the other; for compiled functions, too."""
    corrected, spread = mean.copy(), np.empty(covariance.shape)
    cross, gain, kept = np.empty((4, 2)), np.empty((4, 2)), np.empty((4, 4))
    expected, certainty = np.empty((2, 2)), np.empty((2, 2))
    half = np.empty((4, 4))
    for n in range(len(mean)):
        for i in range(4):
            for j in range(2):
                cross[i, j] = 0.0
                for k in range(4):
                    cross[i, j] += covariance[n, i, k] * matrix[n, j, k]
        for i in range(2):
            for j in range(2):
                expected[i, j] = noise[n, i, j]
                for k in range(4):
                    expected[i, j] += matrix[n, i, k] * cross[k, j]
        inverted(expected, certainty)
        for i in range(4):
            for j in range(2):
                gain[i, j] = cross[i, 0] * certainty[0, j] + cross[i, 1] * certainty[1, j]
                corrected[n, i] += gain[i, j] * innovation[n, j]
            for j in range(4):
                kept[i, j] = -gain[i, 0] * matrix[n, 0, j] - gain[i, 1] * matrix[n, 1, j]
            kept[i, i] += 1.0
        for i in range(4):
            for j in range(4):
                half[i, j] = 0.0
                for k in range(4):
                    half[i, j] += kept[i, k] * covariance[n, k, j]
        for i in range(4):
            for j in range(i + 1):
                value = 0.0
                for k in range(4):
                    value += half[i, k] * kept[j, k]
                for k in range(2):
                    value += gain[i, k] * (
                        noise[n, k, 0] * gain[j, 0] + noise[n, k, 1] * gain[j, 1]
                    )
                spread[n, i, j] = spread[n, j, i] = value
    return corrected, spread
