"""Tracks by global nearest neighbours and counters (likelihood-grid paper, Algorithm 1)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.fusion.likelihood_grid.config import TargetsConfig
from mctrack_ros.tracking.kalman import position_matrix, predict, update

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BEYOND = 1e6
"""Cost of a pair beyond the gate: an assignment refuses infinite ones."""
ACCELERATION_DENSITY = 2.0
"""Of people who walk, m^2/s^3; `fusion.motion.acceleration_density` of the joint tracker."""
FIRST_SPEED = 1.0
"""Standard deviation of the velocity of a new target, m/s."""
NOISE_M = 0.1
"""Standard deviation of a measurement: the paper's errors are mostly below 0.10 to 0.15 m."""


@dataclass(frozen=True, eq=False, slots=True)
class Targets:
    """
    Targets, one row each.

    Attributes
    ----------
    track_id : (n,) int array
        Ascending.
    mean, covariance : (n, 4), (n, 4, 4) arrays
        x, y, vx, vy; m and m/s.
    counter_s : (n,) array
        For how long it would be kept without a measurement, s: Algorithm 1's counter, in time.
    first_ns : (n,) int array
        When it was measured first, ns.
    confirmed : (n,) bool array
        Whether it is published.
    measurement : (n,) int array
        That of this tick; -1: none.

    """

    track_id: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    mean: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 4, 4)))
    counter_s: Floats = field(default_factory=lambda: np.zeros(0))
    first_ns: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    confirmed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    measurement: Indices = field(default_factory=lambda: np.zeros(0, np.int64))

    def __len__(self) -> int:
        """Return the number of targets."""
        return len(self.track_id)

    def select(self, rows: NDArray[np.bool_]) -> Targets:
        """Return some."""
        return Targets(*(getattr(self, name)[rows] for name in self.__slots__))

    def followed_by(self, others: Targets) -> Targets:
        """Return these and others."""
        pairs = ((getattr(self, name), getattr(others, name)) for name in self.__slots__)
        return Targets(*(np.concatenate(pair) for pair in pairs))


def assigned(predicted: Floats, measured: Floats, gate: float) -> Indices:
    """
    Return the measurement of each target, (n,), -1: none (equation 7).

    As many pairs as can be within the gate, of these those with the smallest sum of distances.
    Pairs beyond the gate are no pairs, on either side.

    Parameters
    ----------
    predicted, measured : (n, 2), (m, 2) arrays
        m.
    gate : float
        Radius, m.

    """
    chosen = np.full(len(predicted), -1)
    if len(predicted) and len(measured):
        distance = np.linalg.norm(predicted[:, None] - measured[None], axis=2)
        row, column = linear_sum_assignment(np.where(distance <= gate, distance, BEYOND))
        near = distance[row, column] <= gate
        chosen[row[near]] = column[near]
    return chosen


def predicted(targets: Targets, seconds: float) -> Targets:
    """Return targets some time later, s."""
    mean, covariance = predict(targets.mean, targets.covariance, seconds, ACCELERATION_DENSITY)
    return _with(targets, mean=mean, covariance=covariance)


def matched(
    targets: Targets,
    measured: Floats,
    noise: Floats,
    seconds: float,
    config: TargetsConfig,
) -> Targets:
    """
    Move predicted targets to their measurements, count, and end those whose counter is empty.

    A target without a measurement is counted down also where there are fewer measurements than
    targets, on which the paper is silent.

    Parameters
    ----------
    targets : Targets
        Predicted.
    measured, noise : (m, 2), (m, 2, 2) arrays
        Where people are, m, and how well that is known, m².
    seconds : float
        Since the last tick, s.
    config : TargetsConfig
        Gate and times.

    """
    chosen = assigned(targets.mean[:, :2], measured, config.gate)
    hit = chosen >= 0
    mean, covariance = targets.mean.copy(), targets.covariance.copy()
    if hit.any():
        innovation = measured[chosen[hit]] - mean[hit, :2]
        mean[hit], covariance[hit] = update(
            mean[hit], covariance[hit], innovation, noise[chosen[hit]], position_matrix()
        )
    most = max(config.keep_time, 2 * seconds)
    counter = np.where(
        hit, np.minimum(targets.counter_s + seconds, most), targets.counter_s - seconds
    )
    confirmed = targets.confirmed | (hit & (counter >= config.confirm_time))
    return _with(
        targets,
        mean=mean,
        covariance=covariance,
        counter_s=counter,
        confirmed=confirmed,
        measurement=chosen,
    )


def begun(
    measured: Floats, noise: Floats, first_id: int, stamp_ns: int, seconds: float
) -> Targets:
    """Return new targets at measurements, (m, 2) m with covariances (m, 2, 2), m²."""
    count = len(measured)
    covariance = np.zeros((count, 4, 4))
    covariance[:, :2, :2] = noise
    covariance[:, 2:, 2:] = FIRST_SPEED**2 * np.eye(2)
    return Targets(
        track_id=first_id + np.arange(count),
        mean=np.column_stack([measured, np.zeros((count, 2))]),
        covariance=covariance,
        counter_s=np.full(count, seconds),
        first_ns=np.full(count, stamp_ns),
        confirmed=np.zeros(count, np.bool_),
        measurement=np.full(count, -1),
    )


def _with(targets: Targets, **columns: NDArray[np.generic]) -> Targets:
    return Targets(*(columns.get(name, getattr(targets, name)) for name in Targets.__slots__))
