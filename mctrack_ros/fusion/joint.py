"""The joint assignment of all pictures of a tick to the tracks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.costs import prior_costs
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import AssociationConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.association import assign, gaussian_distance, pair_probabilities
from mctrack_ros.tracking.kalman import inverse, symmetric

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

NOTHING = -1
SWEEPS = 3
"""Of the assignment: by prediction alone, then corrected at most this often less one."""


class JointAssignment:
    """
    Assigns every picture of a tick one to one, each in the light of the others.

    A picture is assigned (global nearest neighbour) first to the predicted tracks, then again to
    what prediction and all *other* pictures say of them, until nothing changes: the joint
    assignment's iterated conditional modes (Besag 1986). One picture's mistake is so corrected by
    the others instead of dragging them along, and the order of the cameras does not matter. A
    pair counts for as much as it is probable, so a doubtful one moves its track little.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp.
    looks : Looks
        The pictures.
    config : AssociationConfig
        Parameters.

    """

    def __init__(self, table: TrackTable, looks: Looks, config: AssociationConfig) -> None:
        self._gate = config.gate
        self._matrix, self._single = looks.matrix, looks.single
        self._position, self._noise = looks.position[looks.single], looks.noise[looks.single]
        self._picture = looks.picture[looks.single]
        self._information = inverse(self._noise)
        self._cost = prior_costs(table, looks, config)
        self._prior = table.mean, table.covariance
        self._prior_information = np.linalg.inv(table.covariance)
        self._taken = np.full((len(looks.matrix), len(table)), NOTHING, np.intp)
        self._weight = np.zeros_like(self._information)

    def solve(self) -> tuple[Floats, Floats]:
        """Return the updated means (n, 4) and covariances (n, 4, 4) of the best assignment."""
        state = self._prior
        for _ in range(SWEEPS):
            taken, probability = self._assigned(*self._without_own(*state))
            if np.array_equal(taken, self._taken):
                break
            self._taken, self._weight = taken, probability[:, None, None] * self._information
            state = self._updated()
        return state

    def pairs(self) -> tuple[Indices, Indices]:
        """Return the tracks (k,) and the detections (k,) of all pairs, by picture, then track."""
        picture, rows = np.nonzero(self._taken != NOTHING)
        return rows, self._single[self._taken[picture, rows]]

    def _assigned(self, predicted: Floats, spread: Floats) -> tuple[Indices, Floats]:
        """Return what each picture has of each track (pictures, n), how probably (m,) it does."""
        gap = self._position[:, None] - predicted[self._picture]
        total = spread[self._picture] + self._noise[:, None]
        squared, log_determinant = gaussian_distance(gap, total)
        cost = np.where(squared < self._gate, squared + log_determinant + self._cost, np.inf)
        columns, rows = assign(cost, self._picture)
        taken, probability = np.full_like(self._taken, NOTHING), np.zeros(len(cost))
        taken[self._picture[columns], rows] = columns
        every = pair_probabilities(np.exp(-cost / 2), self._picture)
        probability[columns] = every[columns, rows]
        return taken, probability

    def _updated(self) -> tuple[Floats, Floats]:
        """Return the states that all pairs make of the prediction: the information filter."""
        picture, row = np.nonzero(self._taken != NOTHING)
        column = self._taken[picture, row]
        weight = self._matrix[picture].swapaxes(1, 2) @ self._weight[column]
        added = np.zeros((*self._taken.shape, 4, 5))
        added[picture, row, :, :4] = weight @ self._matrix[picture]
        innovation = self._position[column] - self._seen_from(picture, self._prior[0][row])
        added[picture, row, :, 4] = (weight @ innovation[..., None])[..., 0]
        total = added.sum(axis=0)
        covariance = symmetric(np.linalg.inv(self._prior_information + total[..., :4]))
        return self._prior[0] + (covariance @ total[..., 4:])[..., 0], covariance

    def _without_own(self, mean: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        """Return positions (pictures, n, 2) and their spread as known without that picture."""
        position = mean @ self._matrix.swapaxes(1, 2)
        transposed = self._matrix.swapaxes(1, 2)[:, None]
        spread = self._matrix[:, None] @ covariance @ transposed
        picture, row = np.nonzero(self._taken != NOTHING)
        column = self._taken[picture, row]
        known = inverse(spread[picture, row])
        rest = symmetric(inverse(known - self._weight[column]))
        pull = self._weight[column] @ (position[picture, row] - self._position[column])[..., None]
        position[picture, row] += (rest @ pull)[..., 0]
        spread[picture, row] = rest
        return position, spread

    def _seen_from(self, picture: Indices, mean: Floats) -> Floats:
        return (self._matrix[picture] @ mean[..., None])[..., 0]
