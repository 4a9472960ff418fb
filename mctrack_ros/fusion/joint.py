"""The joint assignment of all pictures of a tick to the tracks."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, FLOATS_3D, INTS_1D, INTS_2D, compiled, inner
from mctrack_ros.fusion.costs import prior_costs
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import AssociationConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.association import assign, pair_probabilities
from mctrack_ros.tracking.kalman import inverse, inverted, symmetric

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
        single = looks.single
        self._gate, self._single = config.gate, single
        self._matrix = looks.matrix
        self._position, self._noise = looks.position[single], looks.noise[single]
        self._picture = looks.picture[single]
        self._information = inverse(self._noise)
        self._cost = prior_costs(table, looks, config)
        self._mean, self._covariance = table.mean, table.covariance
        self._prior_information = np.linalg.inv(table.covariance)
        self._taken = np.full((len(looks.matrix), len(table)), NOTHING, np.intp)
        self._weight = np.zeros_like(self._information)

    def solve(self) -> tuple[Floats, Floats]:
        """Return the updated means (n, 4) and covariances (n, 4, 4) of the best assignment."""
        state = self._mean, self._covariance
        for _ in range(SWEEPS):
            taken, probability = self._assigned(*state)
            if np.array_equal(taken, self._taken):
                break
            self._taken, self._weight = taken, probability[:, None, None] * self._information
            state = self._updated()
        return state

    def pairs(self) -> tuple[Indices, Indices]:
        """Return the tracks (k,) and the detections (k,) of all pairs, by picture, then track."""
        picture, rows = np.nonzero(self._taken != NOTHING)
        return rows, self._single[self._taken[picture, rows]]

    def _assigned(self, mean: Floats, covariance: Floats) -> tuple[Indices, Floats]:
        """Return what each picture has of each track (pictures, n), how probably (m,) it does."""
        cost = _costs(
            self._matrix,
            mean,
            covariance,
            self._taken,
            self._weight,
            self._position,
            self._noise,
            self._picture,
            self._cost,
            self._gate,
        )
        columns, rows = assign(cost, self._picture)
        taken, probability = np.full_like(self._taken, NOTHING), np.zeros(len(cost))
        taken[self._picture[columns], rows] = columns
        every = pair_probabilities(np.exp(-cost / 2), self._picture)
        probability[columns] = every[columns, rows]
        return taken, probability

    def _updated(self) -> tuple[Floats, Floats]:
        """Return the states that all pairs make of the prediction: the information filter."""
        information, pull = _told(
            self._matrix, self._mean, self._taken, self._weight, self._position
        )
        spread = np.linalg.inv(self._prior_information + information)
        covariance = symmetric(np.asarray(spread, np.float64))
        return self._mean + (covariance @ pull[..., None])[..., 0], covariance


@inner
def _see(matrix: Floats, mean: Floats, covariance: Floats, place: Floats, spread: Floats) -> None:
    """Write where (2,) and how sharply (2, 2) a picture's (2, 4) matrix shows a state."""
    for i in range(2):
        place[i] = 0.0
        for k in range(4):
            place[i] += matrix[i, k] * mean[k]
        for j in range(2):
            spread[i, j] = 0.0
            for k in range(4):
                for m in range(4):
                    spread[i, j] += matrix[i, k] * covariance[k, m] * matrix[j, m]


@inner
def _distance(
    place: Floats, spread: Floats, position: Floats, noise: Floats
) -> tuple[float, float]:
    """Return the squared distance of a measurement, and the determinant of its covariance."""
    x, y = position[0] - place[0], position[1] - place[1]
    xx, yy = spread[0, 0] + noise[0, 0], spread[1, 1] + noise[1, 1]
    xy = spread[0, 1] + noise[0, 1]
    determinant = xx * yy - xy * xy
    return (yy * x * x - 2 * xy * x * y + xx * y * y) / determinant, determinant


@inner
def _take_out(place: Floats, spread: Floats, position: Floats, weight: Floats) -> None:
    """Take what a measurement, so sure, has told out of a place (2,) and its spread (2, 2)."""
    rest, pull = np.empty((2, 2)), np.empty(2)
    inverted(spread, rest)
    inverted(rest - weight, spread)
    spread[0, 1] = spread[1, 0] = (spread[0, 1] + spread[1, 0]) / 2
    for i in range(2):
        pull[i] = weight[i, 0] * (place[0] - position[0]) + weight[i, 1] * (place[1] - position[1])
    for i in range(2):
        place[i] += spread[i, 0] * pull[0] + spread[i, 1] * pull[1]


@compiled(
    types.f8[:, ::1](
        FLOATS_3D, FLOATS_2D, FLOATS_3D, INTS_2D, FLOATS_3D, FLOATS_2D, FLOATS_3D, INTS_1D,
        FLOATS_2D, types.f8,
    )
)  # fmt: skip
def _costs(
    matrix: Floats, mean: Floats, covariance: Floats, taken: Indices, weight: Floats,
    position: Floats, noise: Floats, picture: Indices, prior: Floats, gate: float,
) -> Floats:  # fmt: skip
    """Return the (m, n) costs of all pairs, given what the other pictures say of the tracks."""
    cost = np.full(prior.shape, np.inf)
    place, spread = np.empty(2), np.empty((2, 2))
    for track in range(len(mean)):
        last = -1
        for row in range(len(position)):
            one = picture[row]
            if one != last:
                last, column = one, taken[one, track]
                _see(matrix[one], mean[track], covariance[track], place, spread)
                if column != NOTHING:
                    _take_out(place, spread, position[column], weight[column])
            squared, determinant = _distance(place, spread, position[row], noise[row])
            if squared < gate:
                cost[row, track] = squared + np.log(determinant) + prior[row, track]
    return cost


@compiled(types.f8[:, ::1](FLOATS_3D, FLOATS_2D, FLOATS_3D, FLOATS_2D, FLOATS_3D))
def distances(
    matrix: Floats, mean: Floats, covariance: Floats, position: Floats, noise: Floats
) -> Floats:
    """Return the (m, n) squared Mahalanobis distances of measurements, each of its own picture."""
    squared = np.empty((len(position), len(mean)))
    place, spread = np.empty(2), np.empty((2, 2))
    for row in range(len(position)):
        for track in range(len(mean)):
            _see(matrix[row], mean[track], covariance[track], place, spread)
            squared[row, track] = _distance(place, spread, position[row], noise[row])[0]
    return squared


@compiled(
    types.Tuple([types.f8[:, :, ::1], types.f8[:, ::1]])(
        FLOATS_3D, FLOATS_2D, INTS_2D, FLOATS_3D, FLOATS_2D
    )
)
def _told(
    matrix: Floats, mean: Floats, taken: Indices, weight: Floats, position: Floats
) -> tuple[Floats, Floats]:
    """Return the information (n, 4, 4) that all pairs add to the tracks, and its pull (n, 4)."""
    information, pull = np.zeros((len(mean), 4, 4)), np.zeros((len(mean), 4))
    weighed, gap = np.empty((4, 2)), np.empty(2)
    for picture in range(len(matrix)):
        seen_from = matrix[picture]
        for track in range(len(mean)):
            row = taken[picture, track]
            if row == NOTHING:
                continue
            for j in range(2):
                gap[j] = position[row, j]
                for k in range(4):
                    gap[j] -= seen_from[j, k] * mean[track, k]
                    weighed[k, j] = (
                        seen_from[0, k] * weight[row, 0, j] + seen_from[1, k] * weight[row, 1, j]
                    )
            for i in range(4):
                pull[track, i] += weighed[i, 0] * gap[0] + weighed[i, 1] * gap[1]
                for k in range(4):
                    information[track, i, k] += (
                        weighed[i, 0] * seen_from[0, k] + weighed[i, 1] * seen_from[1, k]
                    )
    return information, pull
