"""How 25 people move over the pitch: roles, the ball, marking, crowding, standing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.pitch.intent import PLAYERS, Intent
from mctrack_ros.simulation.pitch.play import Play, course_of_play
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]

MAX_SPEED = 8.0
"""Highest speed, m/s."""

MAX_ACCELERATION = 4.0
"""Highest acceleration and braking, m/s²."""

_START_M, _STOP_M = 0.8, 0.3
_WALK_PER_M, _RUN_PER_M, _NEAR_M = 0.45, 0.2, 5.0
_ROOM_M, _LOOK_AHEAD_S, _STEP_ASIDE = 0.75, 0.3, 5.0
_TURN_S = 0.25


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """
    Where everybody is, at the middle of every period.

    Attributes
    ----------
    position : (steps, n, 2) array
        On the ground, m.
    velocity : (steps, n, 2) array
        In m/s.
    heading : (steps, n) array
        Direction that the body faces, rad from the x axis.
    stride : (steps, n) array
        Phase of the gait, rad.

    """

    position: Floats
    velocity: Floats
    heading: Floats
    stride: Floats


def simulate_motion(scenario: Scenario) -> Motion:
    """Return the motion of all players; the same scenario gives the same bytes."""
    play = course_of_play(scenario, np.random.default_rng([scenario.seed, 1]))
    walker = _Walker(scenario, play, np.random.default_rng([scenario.seed, 2]))
    rows = [walker.step(step) for step in range(scenario.steps)]
    return Motion(*(np.stack(column) for column in zip(*rows)))


class _Walker:
    """All players at one moment, stepped forward together."""

    def __init__(self, scenario: Scenario, play: Play, rng: np.random.Generator) -> None:
        self._period, self._play = scenario.period_s, play
        self._intent = Intent(scenario, play, rng)
        self._top_speed = rng.uniform(6.4, MAX_SPEED, PLAYERS)
        self._position = self._intent.start()
        self._target = self._position
        self._velocity = np.zeros((PLAYERS, 2))
        self._facing = self._unit(play.ball[0] - self._position)
        self._stride = rng.uniform(0, 2 * np.pi, PLAYERS)
        self._moving = np.ones(PLAYERS, np.bool_)

    def step(self, step: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Move everybody by one period; return position, velocity, heading and stride."""
        wanted = self._velocity_towards(self._intent.targets(step, self._position))
        wanted = self._limited(wanted + self._stepping_aside(), self._top_speed)
        change = self._limited(wanted - self._velocity, MAX_ACCELERATION * self._period)
        before, self._velocity = self._velocity, self._velocity + change
        self._position = self._position + (before + self._velocity) / 2 * self._period
        self._turn(self._play.ball[step])
        heading = np.arctan2(self._facing[:, 1], self._facing[:, 0])
        return self._position, self._velocity, heading, self._stride

    def _velocity_towards(self, target: Floats) -> Floats:
        """Stand when there, walk to what is near, run to what is far."""
        gap = target - self._position
        drift = (target - self._target) / self._period
        self._target = target
        drift *= np.linalg.norm(drift, axis=1, keepdims=True) < MAX_SPEED
        distance = np.linalg.norm(gap, axis=1)
        self._moving = np.where(self._moving, distance > _STOP_M, distance > _START_M)
        walk, hurry = 0.4 + _WALK_PER_M * distance, _RUN_PER_M * (distance - _NEAR_M)
        speed = np.minimum(walk + np.maximum(hurry, 0), self._top_speed) * self._moving
        return np.asarray(self._unit(gap) * speed[:, None] + drift * self._moving[:, None])

    def _stepping_aside(self) -> Floats:
        """Return the velocity that keeps people from walking through one another."""
        ahead = self._position + _LOOK_AHEAD_S * self._velocity
        apart = ahead[:, None] - ahead[None]
        distance = np.sqrt((apart**2).sum(axis=2)) + np.eye(PLAYERS) * 1e3
        push = np.maximum(_ROOM_M - distance, 0) / _ROOM_M * _STEP_ASIDE
        return np.asarray((apart / np.maximum(distance, 0.05)[..., None] * push[..., None]).sum(1))

    def _turn(self, ball: Floats) -> None:
        """Face where one runs; standing, the ball; swing the legs with speed."""
        speed = np.linalg.norm(self._velocity, axis=1)
        runs = np.clip((speed - 0.4) / 0.8, 0, 1)[:, None]
        aim = runs * self._unit(self._velocity) + (1 - runs) * self._unit(ball - self._position)
        share = 1 - np.exp(-self._period / _TURN_S)
        self._facing = self._unit(self._facing + share * (aim - self._facing) + 1e-9)
        strides_hz = np.where(speed > 0.2, 0.7 + 0.12 * speed, 0)
        self._stride = self._stride + 2 * np.pi * strides_hz * self._period

    @staticmethod
    def _limited(vectors: Floats, length: Floats | float) -> Floats:
        norm = np.linalg.norm(vectors, axis=1)
        return np.asarray(vectors * np.minimum(1, length / np.maximum(norm, 1e-9))[:, None])

    @staticmethod
    def _unit(vectors: Floats) -> Floats:
        norm = np.linalg.norm(vectors, axis=1, keepdims=True)
        return np.asarray(vectors / np.maximum(norm, 1e-9))
