"""A pitch on which only a few people walk, each on a given path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mctrack_ros.simulation.pitch.intent import PLAYERS
from mctrack_ros.simulation.pitch.players import Motion
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.world import World

Floats = NDArray[np.float64]

NOWHERE_M = (-500.0, -500.0)
"""Where those are who are not on the pitch."""

_SMOOTH_S = 0.4
_STANDS_BELOW = 0.2  # m/s


@dataclass(frozen=True, slots=True)
class Walk:
    """
    What one person does.

    Attributes
    ----------
    person : int
        Index of who it is: 0 to 10 wear one team's kit, 11 to 21 the other's, 22 to 24 that of
        the referees.
    stops : tuple of (float, float, float)
        Seconds since the start, x and y, m, ascending in time: straight from one to the next.

    """

    person: int
    stops: tuple[tuple[float, float, float], ...]


def staged(scenario: Scenario, walks: Sequence[Walk]) -> World:
    """Return the world in which only these people are on the pitch, each on a given path."""
    shape = (scenario.steps, PLAYERS)
    position = np.tile(NOWHERE_M, (*shape, 1))
    active = np.zeros(shape, np.bool_)
    for walk in walks:
        position[:, walk.person] = _course(scenario, walk)
        active[:, walk.person] = True
    return placed(scenario, position, active)


def placed(scenario: Scenario, position: Floats, active: NDArray[np.bool_]) -> World:
    """
    Return the world in which people are at given places.

    Parameters
    ----------
    scenario : Scenario
        Its steps and cameras.
    position : (steps, n, 2) array
        Everybody's places, m, continuous also while absent.
    active : (steps, n) bool array
        Who is on the pitch.

    """
    velocity = (
        np.gradient(position, scenario.period_s, axis=0) if len(position) > 1 else 0 * position
    )
    speed = np.linalg.norm(velocity, axis=2)
    strides_hz = np.where(speed > _STANDS_BELOW, 0.7 + 0.12 * speed, 0)
    stride = np.arange(PLAYERS) + 2 * np.pi * np.cumsum(strides_hz, axis=0) * scenario.period_s
    there = np.where(active[..., None], position, NOWHERE_M)
    motion = Motion(there, velocity, _headings(velocity, speed), stride)
    return replace(World.of(scenario, motion), active=active)


def _course(scenario: Scenario, walk: Walk) -> Floats:
    """Return somebody's places, (steps, 2) m: straight lines with rounded corners."""
    seconds = (np.arange(scenario.steps) + 0.5) * scenario.period_s
    when, *places = np.array(walk.stops, np.float64).T
    straight = np.column_stack([np.interp(seconds, when, place) for place in places])
    window = 2 * round(_SMOOTH_S * scenario.rate_hz / 2) + 1
    return np.asarray(uniform_filter1d(straight, window, axis=0, mode='nearest'))


def _headings(velocity: Floats, speed: Floats) -> Floats:
    """Return where bodies face, (steps, n) rad: where they walk, or walked last."""
    heading = np.arctan2(velocity[..., 1], velocity[..., 0])
    last = np.where(speed > _STANDS_BELOW, np.arange(len(speed))[:, None], 0)
    return np.asarray(np.take_along_axis(heading, np.maximum.accumulate(last, axis=0), axis=0))
