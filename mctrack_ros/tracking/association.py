"""Distances between tracks and detections, and the best one-to-one assignment of them."""

from __future__ import annotations

from typing import Any

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


def pair_probabilities(likelihood: Floats, part: Indices) -> Floats:
    """
    Return how probable pairs of the same part, a picture, are: the cheap JPDA.

    Each competes with all that share its row or, in its part, its column, and with there being
    no pair (Fitzgerald 1986, "Development of practical PDA logic for multitarget tracking by
    microprocessor").

    Parameters
    ----------
    likelihood : (n, m) array
        Of each pair, relative to no pair.
    part : (n,) int array
        Which part each row belongs to; ascending.

    Returns
    -------
    (n, m) array

    """
    per_row, per_column = likelihood.sum(axis=1, keepdims=True), _column_sums(likelihood, part)
    probability: Floats = likelihood / (1.0 + per_row + per_column - likelihood)
    return probability


def assign(cost: Floats, part: Indices, limit: float = 0.0) -> tuple[Indices, Indices]:
    """
    Find the one-to-one assignments, one a part, that minimise the sum of ``cost - limit``.

    In each part (a picture) a row and a column have one partner at most. Pairs that cost the
    limit or more are never made. Pairs that compete with no other are settled first, which
    changes nothing but the time.

    Parameters
    ----------
    cost : (n, m) array
        Cost of each pair; infinite where it is not allowed.
    part : (n,) int array
        Which part each row belongs to; ascending.
    limit : float
        What leaving both sides unassigned costs.

    Returns
    -------
    rows, columns : (k,) arrays
        The pairs, sorted by row.

    """
    allowed = cost < limit
    alone = allowed & (allowed.sum(axis=1, keepdims=True) == 1)
    alone &= _column_sums(allowed, part) == 1
    rows, columns = np.nonzero(alone)
    contested = allowed & ~alone.any(axis=1, keepdims=True)
    if not contested.any():
        return rows, columns
    more_rows, more_columns = _contested(cost - limit, contested, part)
    rows, columns = np.append(rows, more_rows), np.append(columns, more_columns)
    order = np.argsort(rows)
    return rows[order], columns[order]


def _contested(cost: Floats, contested: NDArray[np.bool_], part: Indices) -> tuple[Indices, ...]:
    """Assign contested pairs: one problem whose columns are those of every part apart."""
    pair_row, pair_column = np.nonzero(contested)
    rows, row = np.unique(pair_row, return_inverse=True)
    slot = part[pair_row] * contested.shape[1] + pair_column
    slots, column = np.unique(slot, return_inverse=True)
    block = np.zeros((len(rows), len(slots)))
    block[row, column] = cost[pair_row, pair_column]
    picked_rows, picked_slots = linear_sum_assignment(block)
    useful = block[picked_rows, picked_slots] < 0
    return rows[picked_rows[useful]], slots[picked_slots[useful]] % contested.shape[1]


def _column_sums(values: NDArray[Any], part: Indices) -> Floats:
    """Return for each row of (n, m) values the sums of the columns over its part."""
    if len(part) == 0:
        return values.astype(float)
    begins = np.concatenate([[True], part[1:] != part[:-1]])
    sums = np.add.reduceat(values, np.flatnonzero(begins), axis=0, dtype=float)
    each: Floats = sums[np.cumsum(begins) - 1]
    return each
