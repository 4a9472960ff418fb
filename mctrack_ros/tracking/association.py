"""Distances between tracks and detections, and the best one-to-one assignment of them."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.compiled import FLOATS_2D, INTS_1D, compiled

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
_INDICES = types.i8[::1]
_SETTLED = types.Tuple([_INDICES, _INDICES, types.f8[:, ::1], _INDICES, _INDICES])


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
    return _probabilities(np.ascontiguousarray(likelihood, np.float64), _indices(part))


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
    rows, columns, block, block_rows, block_columns = _settled(
        np.ascontiguousarray(cost, np.float64), _indices(part), float(limit)
    )
    if block.size == 0:
        return rows, columns
    row, column = linear_sum_assignment(block)
    useful = block[row, column] < 0
    rows = np.append(rows, block_rows[row[useful]])
    columns = np.append(columns, block_columns[column[useful]])
    order = np.argsort(rows)
    return rows[order], columns[order]


def _indices(part: Indices) -> Indices:
    """Return indices as compiled functions take them."""
    return np.ascontiguousarray(part, np.int64)


@compiled(types.f8[:, ::1](FLOATS_2D, INTS_1D))
def _probabilities(likelihood: Floats, part: Indices) -> Floats:
    rows, columns = likelihood.shape
    probability = np.empty((rows, columns))
    first = 0
    while first < rows:
        last = first + 1
        while last < rows and part[last] == part[first]:
            last += 1
        per_column = np.zeros(columns)
        for row in range(first, last):
            per_column += likelihood[row]
        for row in range(first, last):
            per_row = likelihood[row].sum()
            for column in range(columns):
                own = likelihood[row, column]
                probability[row, column] = own / (1.0 + per_row + per_column[column] - own)
        first = last
    return probability


@compiled(_SETTLED(FLOATS_2D, INTS_1D, types.f8))
def _settled(
    cost: Floats, part: Indices, limit: float
) -> tuple[Indices, Indices, Floats, Indices, Indices]:
    """
    Settle the pairs that compete with no other.

    Returns
    -------
    rows, columns : (k,) arrays
        These pairs, by row.
    block : (r, s) array
        Costs, less the limit, of the other rows and the columns of every part apart; 0 where a
        pair is not allowed.
    block_rows, block_columns : (r,) and (s,) arrays
        Which these are.

    """
    count, width = cost.shape
    parts = part[-1] + 1 if count else 0
    per_row, per_slot = np.zeros(count, np.int64), np.zeros(parts * width, np.int64)
    for row in range(count):
        for column in range(width):
            if cost[row, column] < limit:
                per_row[row] += 1
                per_slot[part[row] * width + column] += 1
    partner = np.full(count, -1)
    row_used, slot_used = np.zeros(count, np.bool_), np.zeros(parts * width, np.bool_)
    for row in range(count):
        for column in range(width):
            if cost[row, column] < limit:
                slot = part[row] * width + column
                if per_row[row] == 1 and per_slot[slot] == 1:
                    partner[row] = column
                else:
                    row_used[row] = slot_used[slot] = True
    settled, rows, slots = (
        np.flatnonzero(partner >= 0),
        np.flatnonzero(row_used),
        np.flatnonzero(slot_used),
    )
    block = np.zeros((len(rows), len(slots)))
    for i in range(len(rows)):
        for j in range(len(slots)):
            own, price = slots[j] // width == part[rows[i]], cost[rows[i], slots[j] % width]
            if own and price < limit:
                block[i, j] = price - limit
    return settled, partner[settled], block, rows, slots % width if width else slots
