"""The joint assignment of all pictures of a tick to the tracks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.costs import prior_costs
from mctrack_ros.fusion.looks import Look
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
    looks : sequence of Look
        The pictures, at least one.
    config : AssociationConfig
        Parameters.

    """

    def __init__(
        self, table: TrackTable, looks: Sequence[Look], config: AssociationConfig
    ) -> None:
        self._gate = config.gate
        self._matrix = np.stack([look.matrix for look in looks])
        self._position = np.concatenate([look.position[look.single] for look in looks])
        self._noise = np.concatenate([look.noise[look.single] for look in looks])
        self._information = inverse(self._noise)
        self._cost = np.concatenate([prior_costs(table, look, config) for look in looks])
        sizes = [len(look.single) for look in looks]
        self._look = np.repeat(np.arange(len(looks)), sizes)
        self._first = np.concatenate([[0], np.cumsum(sizes)])
        self._prior = table.mean, table.covariance
        self._prior_information = np.linalg.inv(table.covariance)
        self._taken = np.full((len(looks), len(table)), NOTHING, np.intp)
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

    def pairs(self, look: int) -> tuple[Indices, Indices]:
        """Return the tracks (k,) of a picture's pairs and their places in its singles (k,)."""
        rows = np.flatnonzero(self._taken[look] != NOTHING)
        return rows, self._taken[look, rows] - self._first[look]

    def _assigned(self, predicted: Floats, spread: Floats) -> tuple[Indices, Floats]:
        """Return what each picture has of each track (looks, n), and how probably (m,) it does."""
        gap = self._position[:, None] - predicted[self._look]
        total = spread[self._look] + self._noise[:, None]
        squared, log_determinant = gaussian_distance(gap, total)
        cost = np.where(squared < self._gate, squared + log_determinant + self._cost, np.inf)
        likelihood = np.exp(-cost / 2)
        taken, probability = np.full_like(self._taken, NOTHING), np.zeros(len(cost))
        for look, (first, end) in enumerate(zip(self._first[:-1], self._first[1:])):
            columns, rows = assign(cost[first:end])
            taken[look, rows] = columns + first
            every = pair_probabilities(likelihood[first:end])
            probability[columns + first] = every[columns, rows]
        return taken, probability

    def _updated(self) -> tuple[Floats, Floats]:
        """Return the states that all pairs make of the prediction: the information filter."""
        look, row = np.nonzero(self._taken != NOTHING)
        column = self._taken[look, row]
        weight = self._matrix[look].swapaxes(1, 2) @ self._weight[column]
        added = np.zeros((*self._taken.shape, 4, 5))
        added[look, row, :, :4] = weight @ self._matrix[look]
        innovation = self._position[column] - self._seen_from(look, self._prior[0][row])
        added[look, row, :, 4] = (weight @ innovation[..., None])[..., 0]
        total = added.sum(axis=0)
        covariance = symmetric(np.linalg.inv(self._prior_information + total[..., :4]))
        return self._prior[0] + (covariance @ total[..., 4:])[..., 0], covariance

    def _without_own(self, mean: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        """Return positions (looks, n, 2) and their spread as known without that picture."""
        position = mean @ self._matrix.swapaxes(1, 2)
        transposed = self._matrix.swapaxes(1, 2)[:, None]
        spread = self._matrix[:, None] @ covariance @ transposed
        look, row = np.nonzero(self._taken != NOTHING)
        column = self._taken[look, row]
        known = inverse(spread[look, row])
        rest = symmetric(inverse(known - self._weight[column]))
        pull = self._weight[column] @ (position[look, row] - self._position[column])[..., None]
        position[look, row] += (rest @ pull)[..., 0]
        spread[look, row] = rest
        return position, spread

    def _seen_from(self, look: Indices, mean: Floats) -> Floats:
        return (self._matrix[look] @ mean[..., None])[..., 0]
