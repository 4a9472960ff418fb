"""Batched constant-velocity Kalman filter on the ground: state (x, y, vx, vy), SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def transition_matrix(seconds: ArrayLike) -> Floats:
    """Return the (..., 4, 4) constant-velocity transitions over times (...), s."""
    seconds = np.asarray(seconds, np.float64)
    matrix = np.zeros((*seconds.shape, 4, 4))
    matrix[..., range(4), range(4)] = 1.0
    matrix[..., 0, 2] = matrix[..., 1, 3] = seconds
    return matrix


def process_noise(seconds: ArrayLike, acceleration_density: float) -> Floats:
    """
    Return the (..., 4, 4) covariances that white-noise acceleration adds over times (...), s.

    Parameters
    ----------
    seconds : array_like
        Durations, not negative, s.
    acceleration_density : float
        Power spectral density of the acceleration, m²/s³.

    """
    seconds = np.asarray(seconds, np.float64)
    matrix = np.zeros((*seconds.shape, 4, 4))
    matrix[..., 0, 0] = matrix[..., 1, 1] = seconds**3 / 3
    matrix[..., 0, 2] = matrix[..., 1, 3] = seconds**2 / 2
    matrix[..., 2, 0] = matrix[..., 3, 1] = seconds**2 / 2
    matrix[..., 2, 2] = matrix[..., 3, 3] = seconds
    return acceleration_density * matrix


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
    transition = transition_matrix(seconds)
    moved = np.einsum('...ij,...j->...i', transition, mean)
    spread = transition @ covariance @ transition.swapaxes(-1, -2)
    return moved, symmetric(spread + process_noise(seconds, acceleration_density))


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
    transposed = measurement_matrix.swapaxes(-1, -2)
    cross = covariance @ transposed
    gain = cross @ inverse(measurement_matrix @ cross + noise)
    kept = np.eye(4) - gain @ measurement_matrix
    spread = kept @ covariance @ kept.swapaxes(-1, -2) + gain @ noise @ gain.swapaxes(-1, -2)
    return mean + (gain @ innovation[..., None])[..., 0], symmetric(spread)


def inverse(matrix: Floats) -> Floats:
    """Return the inverses of (..., 2, 2) matrices."""
    adjugate = np.empty_like(matrix)
    adjugate[..., 0, 0], adjugate[..., 1, 1] = matrix[..., 1, 1], matrix[..., 0, 0]
    adjugate[..., 0, 1], adjugate[..., 1, 0] = -matrix[..., 0, 1], -matrix[..., 1, 0]
    return adjugate / determinant(matrix)[..., None, None]


def determinant(matrix: Floats) -> Floats:
    """Return the determinants of (..., 2, 2) matrices."""
    product: Floats = matrix[..., 0, 0] * matrix[..., 1, 1]
    return product - matrix[..., 0, 1] * matrix[..., 1, 0]


def symmetric(matrix: Floats) -> Floats:
    """Return matrices without the asymmetry that rounding leaves."""
    halved: Floats = (matrix + matrix.swapaxes(-1, -2)) / 2
    return halved
