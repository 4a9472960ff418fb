"""Distances between tracks and detections, and the best one-to-one assignment of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def mahalanobis(
    predicted: Floats, predicted_covariance: Floats, measured: Floats, noise: Floats
) -> tuple[Floats, Floats]:
    """
    Compare every prediction with every measurement.

    Parameters
    ----------
    predicted : (n, 2) array
        Predicted measurements, m or px.
    predicted_covariance : (n, 2, 2) array
        Their covariances.
    measured : (m, 2) array
        Measurements, in the same unit.
    noise : (m, 2, 2) array
        Their covariances.

    Returns
    -------
    squared_distance : (n, m) array
        Squared Mahalanobis distance of the innovation.
    log_determinant : (n, m) array
        Natural logarithm of the determinant of the innovation's covariance.

    """
    gap = measured[None] - predicted[:, None]
    return gaussian_distance(gap, predicted_covariance[:, None] + noise[None])


def gaussian_distance(gap: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """
    Return how far innovations are off, and how uncertain.

    Parameters
    ----------
    gap : (..., 2) array
        Innovations, m or px.
    covariance : (..., 2, 2) array
        Their covariances.

    Returns
    -------
    squared_distance : (...) array
        Squared Mahalanobis distances.
    log_determinant : (...) array
        Natural logarithms of the determinants of the covariances.

    """
    xx, xy, yy = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    x, y = gap[..., 0], gap[..., 1]
    determinant = xx * yy - xy * xy
    squared = (yy * x * x - 2 * xy * x * y + xx * y * y) / determinant
    return squared, np.log(determinant)


def pair_probabilities(likelihood: Floats) -> Floats:
    """
    Return how probable the pairs of one picture are: the cheap JPDA.

    Each competes with all that share its row or its column, and with there being no pair
    (Fitzgerald 1986, "Development of practical PDA logic for multitarget tracking by
    microprocessor").

    Parameters
    ----------
    likelihood : (n, m) array
        Of each pair, relative to no pair.

    Returns
    -------
    (n, m) array

    """
    per_row, per_column = likelihood.sum(axis=1, keepdims=True), likelihood.sum(axis=0)
    probability: Floats = likelihood / (1.0 + per_row + per_column - likelihood)
    return probability


def assign(cost: Floats, limit: float = 0.0) -> tuple[Indices, Indices]:
    """
    Find the one-to-one assignment that minimises the sum of ``cost - limit`` over its pairs.

    Pairs that cost the limit or more are never made. Pairs that compete with no other are settled
    first, which changes nothing but the time.

    Parameters
    ----------
    cost : (n, m) array
        Cost of each pair; infinite where it is not allowed.
    limit : float
        What leaving both sides unassigned costs.

    Returns
    -------
    rows, columns : (k,) arrays
        The pairs, sorted by row.

    """
    allowed = cost < limit
    per_row, per_column = allowed.sum(axis=1), allowed.sum(axis=0)
    alone = allowed & (per_row == 1)[:, None] & (per_column == 1)[None]
    rows, columns = np.nonzero(alone)
    contested_rows = np.flatnonzero((per_row > 0) & ~alone.any(axis=1))
    if len(contested_rows) == 0:
        return rows, columns
    contested_columns = np.flatnonzero((per_column > 0) & ~alone.any(axis=0))
    block = np.minimum(cost[np.ix_(contested_rows, contested_columns)] - limit, 0.0)
    picked = linear_sum_assignment(block)
    useful = block[picked] < 0
    rows = np.concatenate([rows, contested_rows[picked[0][useful]]])
    columns = np.concatenate([columns, contested_columns[picked[1][useful]]])
    order = np.argsort(rows)
    return rows[order], columns[order]
