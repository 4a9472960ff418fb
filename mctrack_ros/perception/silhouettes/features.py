"""Feature vectors of objects and silhouettes, and the comparison that all eight steps use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, compiled, inner
from mctrack_ros.config import parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

BINS = 16  # the paper's number of bins of grey
AREA, WIDTH, HEIGHT = 0, 1, 2
HISTOGRAM = slice(3, 3 + BINS)
PLACE = slice(3 + BINS, 5 + BINS)
SIZE = 5 + BINS
NONE = -1


@dataclass(frozen=True)
class ComparisonConfig:
    """Weights of the parts of a feature vector in a comparison."""

    form_weight: float = parameter(
        1.0, 'weight of each of area, width and height', minimum=0.0, maximum=100.0
    )
    grey_weight: float = parameter(
        1.0, 'weight of each of the 16 bins of the grey histogram', minimum=0.0, maximum=100.0
    )
    place_weight: float = parameter(
        8.0,
        'weight of each of the distances from the expected place, x and y; 0: as printed',
        minimum=0.0,
        maximum=100.0,
    )

    def weights(self) -> Floats:
        """Return the (21,) weights."""
        return np.repeat(
            [self.form_weight, self.grey_weight, self.place_weight], [HISTOGRAM.start, BINS, 2]
        )


@dataclass(frozen=True, eq=False, slots=True)
class Shapes:
    """
    What objects or silhouettes look like, one row each (silhouettes paper, section 3).

    Attributes
    ----------
    vector : (n, 21) float64 array
        Area (px²), width, height (px), pixels in each of 16 bins of grey, and, beyond the paper,
        the centroid (px).
    box : (n, 4) float64 array
        Minimum bounding rectangle: left, top, width, height, px.

    """

    vector: Floats
    box: Floats

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.vector)

    @property
    def area(self) -> Floats:
        """Areas, (n,) px²."""
        return self.vector[:, AREA]

    @property
    def centroid(self) -> Floats:
        """Centroids, (n, 2) px."""
        return self.vector[:, PLACE]

    def select(self, index: Mask | Ints) -> Shapes:
        """Return the rows that a mask or an index array picks."""
        return Shapes(self.vector[index], self.box[index])

    def replaced(self, row: int, other: Shapes) -> Shapes:
        """Return the same rows, but one taken from (1-row) other shapes."""
        vector, box = self.vector.copy(), self.box.copy()
        vector[row], box[row] = other.vector[0], other.box[0]
        return Shapes(vector, box)

    def united(self) -> Shapes:
        """Return one row: the shape of all rows' pixels together, none of which are shared."""
        low, high = self.box[:, :2].min(axis=0), (self.box[:, :2] + self.box[:, 2:]).max(axis=0)
        vector = self.vector.sum(axis=0)
        vector[[WIDTH, HEIGHT]] = high - low
        vector[PLACE] = self.area @ self.centroid / max(self.area.sum(), 1e-9)
        return Shapes(vector[None], np.concatenate([low, high - low])[None])


def stacked(*parts: Shapes) -> Shapes:
    """Return the rows of several shapes one after another."""
    return Shapes(
        np.concatenate([part.vector for part in parts]),
        np.concatenate([part.box for part in parts]),
    )


@inner
def _cost(target: Floats, new: Floats, old: Floats, weights: Floats) -> float:
    total = 0.0
    for element in range(len(weights)):
        fresh = abs(target[element] - new[element])
        known = abs(target[element] - old[element])
        if fresh + known > 0.0:
            total += weights[element] * (fresh - known) / (fresh + known)
    return total


@compiled(types.f8(FLOATS_1D, FLOATS_1D, FLOATS_1D))
def cost(new: Floats, old: Floats, weights: Floats) -> float:
    """
    Compare a new difference vector with an old one (eqs (6), (10), (13), (14)).

    ``sum_i w_i (new_i - old_i) / (new_i + old_i)``, 0/0 = 0: below zero when the new one is
    better. The denominator scales the elements, so that no large one dominates.
    """
    total = 0.0
    for element in range(len(weights)):
        if new[element] + old[element] > 0.0:
            total += (
                weights[element] * (new[element] - old[element]) / (new[element] + old[element])
            )
    return total


MASK_2D = types.Array(types.b1, 2, 'C', readonly=True)


@compiled(types.i8[::1](FLOATS_2D, FLOATS_2D, MASK_2D, FLOATS_1D))
def best_matches(target: Floats, candidate: Floats, allowed: Mask, weights: Floats) -> Ints:
    """
    Return for each target the candidate that wins a tournament in index order (eq. (6)).

    The comparison is not transitive, so the order belongs to the result.

    Parameters
    ----------
    target : (n, 21) array
        Feature vectors.
    candidate : (m, 21) array
        Feature vectors.
    allowed : (n, m) bool array
        Who may win.
    weights : (21,) array
        Of the elements.

    Returns
    -------
    (n,) int64 array
        Rows of candidates; -1 where none is allowed.

    """
    winner = np.full(len(target), NONE, np.int64)
    for row in range(len(target)):
        for column in range(len(candidate)):
            if not allowed[row, column]:
                continue
            holder = winner[row]
            if holder == NONE or (
                _cost(target[row], candidate[column], candidate[holder], weights) < 0.0
            ):
                winner[row] = column
    return winner
