"""How tracks move on the ground: one constant-velocity filter, or several that interact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.motion.config import (
    ConstantVelocityConfig,
    InteractingConfig,
    MotionConfig,
)
from mctrack_ros.fusion.motion.imm import begin, interact, judge
from mctrack_ros.fusion.motion.information import updated
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import predict

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

INITIAL_SPEED_SIGMA = 2.0
"""Standard deviation of the velocity of a new target, m/s: people walk, and run at twice that."""

FARTHEST_M = 6.0
"""Standard deviation of where somebody is whom nobody has watched for long, m: with more, whoever
is there would rather be a new target."""
STRAIGHT_S = 2.5
"""How long people keep their velocity in the mean, s."""
WALKING_SPEED = 1.0
"""Standard deviation of each part of a person's velocity, m/s."""


class Motion(Protocol):
    """What keeps the states of tracks; the associations know these alone."""

    @property
    def modes(self) -> int:
        """How many modes a track of the table has."""
        ...

    def begin(self, fresh: TrackTable) -> None:
        """Prepare tracks that have a state and nothing else."""
        ...

    def predict(self, table: TrackTable, seconds: float) -> None:
        """Move the states of all tracks on."""
        ...

    def update(self, table: TrackTable, reported: Floats) -> None:
        """Give the tracks what was measured of them, (n, 13), see `gathered`."""
        ...

    def follow(self, table: TrackTable, rows: Indices) -> None:
        """Take notice that the states of some tracks were changed otherwise."""
        ...


@dataclass(frozen=True)
class ConstantVelocity:
    """
    White acceleration of one density.

    Attributes
    ----------
    density : float
        Power spectral density of the acceleration, m²/s³.

    """

    density: float
    modes = 0

    @classmethod
    def configured(cls, config: ConstantVelocityConfig) -> Self:
        """Return the motion that parameters describe."""
        return cls(config.acceleration_density)

    def begin(self, fresh: TrackTable) -> None:
        """Need nothing."""

    def predict(self, table: TrackTable, seconds: float) -> None:
        """Move the states of all tracks on."""
        state = table.mean, table.covariance
        table.mean, table.covariance = predict(*state, seconds, self.density)

    def update(self, table: TrackTable, reported: Floats) -> None:
        """Update the state by what was measured."""
        table.mean, table.covariance = updated(table.mean, table.covariance, reported)

    def follow(self, table: TrackTable, rows: Indices) -> None:
        """Need nothing."""


@lru_cache(maxsize=64)  # ticks are regular, mostly
def _transition(calm: float, manoeuvre: float, seconds: float) -> Floats:
    kept = float(np.exp(-seconds * (1 / calm + 1 / manoeuvre)))
    to_calm = (1 - kept) * (calm / (calm + manoeuvre))
    to_manoeuvre = (1 - kept) * (manoeuvre / (calm + manoeuvre))
    transition = np.array([[kept + to_calm, to_manoeuvre], [to_calm, kept + to_manoeuvre]])
    transition.setflags(write=False)
    return transition


@dataclass(frozen=True)
class InteractingModels:
    """
    An interacting multiple model filter of two modes: calm, and manoeuvring.

    Each is white acceleration of its own density; which one a target is in is a Markov chain in
    continuous time. Blom and Bar-Shalom 1988, "The interacting multiple model algorithm for
    systems with Markovian switching coefficients"; Bar-Shalom, Li and Kirubarajan 2001, section
    11.6.6. The state of the table has the moments of the mixture.

    Attributes
    ----------
    densities : (float, float)
        Power spectral densities of the acceleration, m²/s³.
    times : (float, float)
        How long each mode lasts in the mean, s.

    """

    densities: tuple[float, float]
    times: tuple[float, float]

    @classmethod
    def configured(cls, config: InteractingConfig) -> Self:
        """Return the motion that parameters describe."""
        return cls(
            (config.calm_density, config.manoeuvre_density),
            (config.calm_time, config.manoeuvre_time),
        )

    @property
    def modes(self) -> int:
        """How many modes a track has."""
        return len(self.densities)

    def transition(self, seconds: float) -> Floats:
        """Return how probable each mode (column) is so long after each (row), (2, 2)."""
        return _transition(*self.times, seconds)

    def begin(self, fresh: TrackTable) -> None:
        """Let all modes begin at the state, each as probable as it is at any time."""
        begin(
            fresh.mean,
            fresh.covariance,
            fresh.mode_mean,
            fresh.mode_covariance,
            fresh.mode_probability,
            *self.times,
        )

    def predict(self, table: TrackTable, seconds: float) -> None:
        """Mix the modes and move them on."""
        interact(
            table.mean,
            table.covariance,
            table.mode_mean,
            table.mode_covariance,
            table.mode_probability,
            self.transition(seconds),
            seconds,
            *self.densities,
        )

    def update(self, table: TrackTable, reported: Floats) -> None:
        """Update each mode by what was measured, and judge it by how well it foresaw that."""
        judge(
            table.mean,
            table.covariance,
            table.mode_mean,
            table.mode_covariance,
            table.mode_probability,
            reported,
        )

    def follow(self, table: TrackTable, rows: Indices) -> None:
        """Let all modes of those tracks begin anew at their states."""
        table.mode_mean[rows] = table.mean[rows, None]
        table.mode_covariance[rows] = table.covariance[rows, None]


MODELS: dict[str, Callable[[Any], Motion]] = {
    'constant_velocity': ConstantVelocity.configured,
    'interacting': InteractingModels.configured,
}


def motion_of(config: MotionConfig) -> Motion:
    """Return the motion that parameters describe."""
    return MODELS[config.model](config)


def predict_unwatched(table: TrackTable, seconds: float) -> None:
    """
    Predict the states of all tracks over a time in which nobody looked.

    After seconds nobody is where a straight line leads: velocity is an Ornstein-Uhlenbeck process
    (Uhlenbeck and Ornstein 1930) with the variance of somebody who walks. The position's variance
    then grows with time, not with its third power.

    Parameters
    ----------
    table : TrackTable
        Its states, and those of all modes, are moved on.
    seconds : float
        How long, s.

    """
    tau, left = STRAIGHT_S, float(np.exp(-seconds / STRAIGHT_S))
    density = 2.0 * WALKING_SPEED**2 / tau
    moves = np.eye(2)
    place = density * tau**2 * (seconds - 2 * tau * (1 - left) + tau / 2 * (1 - left**2))
    place = min(place, FARTHEST_M**2)
    both = density * tau**2 / 2 * (1 - left) ** 2
    speed = density * tau / 2 * (1 - left**2)
    transition = np.kron([[1.0, tau * (1 - left)], [0.0, left]], moves)
    noise = np.kron([[place, both], [both, speed]], moves)
    table.mean = table.mean @ transition.T
    table.covariance = transition @ table.covariance @ transition.T + noise
    if table.mode_mean.shape[1]:
        table.mode_mean = table.mode_mean @ transition.T
        table.mode_covariance = transition @ table.mode_covariance @ transition.T + noise
