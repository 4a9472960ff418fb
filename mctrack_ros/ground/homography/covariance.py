"""How far a homography's pixels move with what it was made from: its covariance carried on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.compiled import inner

Floats = NDArray[np.float64]
BLOCKS = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))  # of a symmetric 3 x 3 matrix


def by_entries(matrix: Floats, places: Floats) -> Floats:
    """
    Return the derivatives of a homography's pixels by its nine entries.

    Parameters
    ----------
    matrix : (3, 3) array
        The homography.
    places : (n, 2) array
        What it maps.

    Returns
    -------
    (n, 2, 9) array
        Pixels by entries, row after row.

    """
    corners = np.column_stack([places, np.ones(len(places))])
    mapped = corners @ matrix.T
    derivatives = np.zeros((len(places), 2, 9))
    for axis in range(2):
        along = (mapped[:, axis] / mapped[:, 2])[:, None]
        derivatives[:, axis, 3 * axis : 3 * axis + 3] = corners
        derivatives[:, axis, 6:] = -along * corners
    scaled: Floats = derivatives / mapped[:, 2, None, None]
    return scaled


def spread_terms(covariance: Floats) -> Floats:
    """
    Return the (6, 6) coefficients by which `add_spread` takes a (9, 9) covariance of entries.

    One row for each pair of the homography's rows, of a², ab, b², a, b and 1.
    """
    terms = np.empty((len(BLOCKS), 6))
    for index, (row, column) in enumerate(BLOCKS):
        block = covariance[3 * row : 3 * row + 3, 3 * column : 3 * column + 3]
        both = block + block.T
        terms[index] = (
            block[0, 0], both[0, 1], block[1, 1], both[0, 2], both[1, 2], block[2, 2],
        )  # fmt: skip
    return terms


@inner
def _term(terms: Floats, index: int, a: float, b: float) -> float:
    c = terms[index]
    return float(c[0] * a * a + c[1] * a * b + c[2] * b * b + c[3] * a + c[4] * b + c[5])


@inner
def add_spread(matrix: Floats, terms: Floats, a: float, b: float, spread: Floats) -> None:
    """Add to a (2, 2) covariance that of the pixel of a place, to first order."""
    share = 1.0 / (matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2])
    column = (matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2]) * share
    row = (matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2]) * share
    share *= share
    across, down, depth = _term(terms, 3, a, b), _term(terms, 4, a, b), _term(terms, 5, a, b)
    mixed = _term(terms, 1, a, b) - row * across - column * down + column * row * depth
    spread[0, 0] += share * (
        _term(terms, 0, a, b) - 2.0 * column * across + column * column * depth
    )
    spread[1, 1] += share * (_term(terms, 2, a, b) - 2.0 * row * down + row * row * depth)
    spread[0, 1] += share * mixed
    spread[1, 0] += share * mixed
