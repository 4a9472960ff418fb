"""Tracks by global nearest neighbours and counters (likelihood-grid paper, Algorithm 1)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.fusion.likelihood_grid.config import TargetsConfig
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.tracking.appearance import bhattacharyya_distance
from mctrack_ros.tracking.kalman import position_matrix, predict, update

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BEYOND = 1e6
"""Cost of a pair beyond the gate: an assignment refuses infinite ones."""
ACCELERATION_DENSITY = 2.0
"""Of people who walk, m^2/s^3; `fusion.motion.acceleration_density` of the joint tracker."""
FIRST_SPEED = 1.0
"""Standard deviation of the velocity of a new target, m/s."""
COLOUR_M = 1.0
"""What a Bhattacharyya distance of 1 costs, m: the last section of the paper asks for colour."""
ALONE_M = 0.7
"""Colours of a target are learned while no other is nearer."""
LEARNED = 0.05
"""Share of a measurement's colours in those of its target."""
NOISE_M = 0.1
"""Standard deviation of a measurement: the paper's errors are mostly below 0.10 to 0.15 m."""


class Measured(NamedTuple):
    """
    People of one tick.

    Attributes
    ----------
    position : (m, 2) array
        m.
    noise : (m, 2, 2) array
        Covariances, m².
    template : (m, 48) array
        Colours; zero: not known.

    """

    position: Floats
    noise: Floats
    template: Floats

    def select(self, rows: Indices) -> Measured:
        """Return some."""
        return Measured(*(column[rows] for column in self))


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
    template : (n, 48) array
        Colours; zero: not known.

    """

    track_id: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    mean: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 4, 4)))
    counter_s: Floats = field(default_factory=lambda: np.zeros(0))
    first_ns: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    confirmed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    measurement: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    template: Floats = field(default_factory=lambda: np.zeros((0, TEMPLATE_SIZE)))

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


def assigned(targets: Targets, measured: Measured, gate: float) -> Indices:
    """
    Return the measurement of each target, (n,), -1: none (equation 7).

    As many pairs as can be within the gate, of these those with the smallest sum of distances,
    to which different colours add. Pairs beyond the gate are no pairs, on either side.

    Parameters
    ----------
    targets : Targets
        Predicted.
    measured : Measured
        People.
    gate : float
        Radius, m.

    """
    chosen = np.full(len(targets), -1)
    if len(targets) and len(measured.position):
        gap = targets.mean[:, None, :2] - measured.position[None]
        distance = np.linalg.norm(gap, axis=2)
        other = bhattacharyya_distance(targets.template, measured.template)
        cost = np.where(distance <= gate, distance + COLOUR_M * other, BEYOND)
        row, column = linear_sum_assignment(cost)
        near = distance[row, column] <= gate
        chosen[row[near]] = column[near]
    return chosen


def predicted(targets: Targets, seconds: float) -> Targets:
    """Return targets some time later, s."""
    mean, covariance = predict(targets.mean, targets.covariance, seconds, ACCELERATION_DENSITY)
    return _with(targets, mean=mean, covariance=covariance)


def matched(
    targets: Targets, measured: Measured, seconds: float, config: TargetsConfig
) -> Targets:
    """
    Move predicted targets to their measurements, and count.

    A target without a measurement is counted down also where there are fewer measurements than
    targets, on which the paper is silent.

    Parameters
    ----------
    targets : Targets
        Predicted.
    measured : Measured
        People.
    seconds : float
        Since the last tick, s.
    config : TargetsConfig
        Gate and times.

    """
    chosen = assigned(targets, measured, config.gate)
    hit = chosen >= 0
    own = measured.select(chosen[hit])
    mean, covariance = targets.mean.copy(), targets.covariance.copy()
    mean[hit], covariance[hit] = update(
        mean[hit], covariance[hit], own.position - mean[hit, :2], own.noise, position_matrix()
    )
    most = max(config.keep_time, 2 * seconds)
    counted = np.where(hit, seconds, -seconds)
    counter = np.minimum(targets.counter_s + counted, most)
    confirmed = targets.confirmed | (hit & (counter >= config.confirm_time))
    return _with(
        targets,
        mean=mean,
        covariance=covariance,
        counter_s=counter,
        confirmed=confirmed,
        measurement=chosen,
        template=_learned(targets.template, mean, measured, chosen),
    )


def begun(measured: Measured, first_id: int, stamp_ns: int, seconds: float) -> Targets:
    """Return new targets of measurements."""
    count = len(measured.position)
    covariance = np.zeros((count, 4, 4))
    covariance[:, :2, :2] = measured.noise
    covariance[:, 2:, 2:] = FIRST_SPEED**2 * np.eye(2)
    return Targets(
        track_id=first_id + np.arange(count),
        mean=np.column_stack([measured.position, np.zeros((count, 2))]),
        covariance=covariance,
        counter_s=np.full(count, seconds),
        first_ns=np.full(count, stamp_ns),
        confirmed=np.zeros(count, np.bool_),
        measurement=np.full(count, -1),
        template=measured.template,
    )


def _learned(template: Floats, mean: Floats, measured: Measured, chosen: Indices) -> Floats:
    """Return the colours of targets after a tick."""
    gap = np.linalg.norm(mean[:, None, :2] - mean[None, :, :2], axis=2) + np.diag(
        np.full(len(mean), np.inf)
    )
    alone = (chosen >= 0) & (gap.min(axis=1, initial=np.inf) > ALONE_M)
    rows = np.flatnonzero(alone)
    rows = rows[measured.template[chosen[rows]].any(axis=1)]
    share = np.where(template[rows].any(axis=1), LEARNED, 1.0)[:, None]
    learned = template.copy()
    learned[rows] += share * (measured.template[chosen[rows]] - template[rows])
    return learned


def _with(targets: Targets, **columns: NDArray[np.generic]) -> Targets:
    return Targets(*(columns.get(name, getattr(targets, name)) for name in Targets.__slots__))
