"""Paths over the ground, driven or walked with a speed that fits, read off at a rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.carpark.layout import Bay

Floats = NDArray[np.float64]

TURN_M = 3.5
"""Radius at which cars turn into bays, m."""

_STEP_M = 0.1
_LANE_SPEED, _TURN_SPEED = (3.2, 4.6), 1.7
_ACCELERATION = 1.6
_SWAY_M, _SWAY_HZ = 0.05, 0.35


@dataclass(frozen=True, eq=False, slots=True)
class Course:
    """
    Where somebody or something is, from the first step on.

    Attributes
    ----------
    position : (steps, 2) array
        On the ground, m.
    heading : (steps,) array
        Where it faces, rad.

    """

    position: Floats
    heading: Floats

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self.heading)

    def then(self, other: Course) -> Course:
        """Return this course and another after it."""
        position = np.concatenate([self.position, other.position])
        return Course(position, np.concatenate([self.heading, other.heading]))

    def until(self, steps: int) -> Course:
        """Return the first steps of this course."""
        return Course(self.position[:steps], self.heading[:steps])

    def waiting(self, steps: int) -> Course:
        """Return this course with a wait at its end."""
        return self.then(standing(self.position[-1], float(self.heading[-1]), steps))


def standing(place: Floats, heading: float, steps: int) -> Course:
    """Return the course of something that does not move."""
    return Course(np.tile(place, (steps, 1)), np.full(steps, heading))


def into_bay(place: Floats, bay: Bay, lane_y: float, start_x: float) -> tuple[Floats, Floats]:
    """Return points, (n, 2) m, and headings, rad, from a lane to a place in a bay, nose first."""
    direction = 1.0 if start_x < bay.x else -1.0
    turn_x = bay.x - direction * TURN_M
    angle = np.linspace(0, np.pi / 2, 12)
    arc = np.column_stack(
        [
            turn_x + direction * TURN_M * np.sin(angle),
            lane_y - bay.towards * TURN_M * (1 - np.cos(angle)),
        ]
    )
    corners = np.concatenate([[(start_x, lane_y)], arc, [place]])
    return _dense(corners)


def along(corners: Floats) -> tuple[Floats, Floats]:
    """Return points and headings along a polyline of (n, 2) corners, m."""
    return _dense(np.asarray(corners, np.float64))


def driven(
    points: Floats, heading: Floats, period_s: float, speed: float, start: float, end: float
) -> Course:
    """
    Drive along points: slower where they turn, from one speed to another.

    Parameters
    ----------
    points : (n, 2) array
        The way, evenly spaced, m.
    heading : (n,) array
        Where the car faces, rad.
    period_s : float
        Time between steps, s.
    speed : float
        On straight pieces, m/s.
    start, end : float
        Speeds at both ends, m/s.

    """
    spacing = np.linalg.norm(np.diff(points, axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(spacing)])
    turning = np.abs(np.gradient(np.unwrap(heading), np.maximum(distance, 1e-9))) > 0.02
    limit = np.where(turning, _TURN_SPEED, speed)
    limit[0], limit[-1] = min(limit[0], start), min(limit[-1], end)
    for order in (range(1, len(limit)), range(len(limit) - 2, -1, -1)):
        for index in order:
            near = index - 1 if order.step > 0 else index + 1
            gained = np.sqrt(limit[near] ** 2 + 2 * _ACCELERATION * _STEP_M)
            limit[index] = min(limit[index], gained)
    mean = np.maximum((limit[1:] + limit[:-1]) / 2, 0.1)
    clock = np.concatenate([[0.0], np.cumsum(spacing / mean)])
    at = np.interp(np.arange(0, clock[-1], period_s), clock, distance)
    position = np.stack([np.interp(at, distance, points[:, axis]) for axis in (0, 1)], axis=1)
    return Course(position, np.interp(at, distance, np.unwrap(heading)))


def lane_speed(rng: np.random.Generator) -> float:
    """Return how fast somebody drives along a lane, m/s."""
    return float(rng.uniform(*_LANE_SPEED))


def walked(corners: Floats, period_s: float, speed: float, rng: np.random.Generator) -> Course:
    """Walk along a polyline of (n, 2) corners, m, with round corners and not quite straight."""
    points, _ = _dense(np.asarray(corners, np.float64))
    wander = np.cumsum(rng.normal(scale=0.02, size=points.shape), axis=0)
    wander -= np.linspace(0, 1, len(points))[:, None] * wander[-1]
    points = _smoothed(points + np.clip(wander, -0.3, 0.3))
    spacing = np.linalg.norm(np.diff(points, axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(spacing)])
    at = np.arange(0, distance[-1], speed * period_s)
    position = np.stack([np.interp(at, distance, points[:, axis]) for axis in (0, 1)], axis=1)
    return Course(position, headings(position))


def swaying(
    place: Floats, heading: float, steps: int, period_s: float, rng: np.random.Generator
) -> Course:
    """Stand as people do: never quite still (silhouettes, section 5)."""
    clock = np.arange(steps) * period_s
    phase = rng.uniform(0, 2 * np.pi, 2)
    rate = 2 * np.pi * _SWAY_HZ * rng.uniform(0.7, 1.3, 2)
    sway = _SWAY_M * np.sin(clock[:, None] * rate + phase) - _SWAY_M * np.sin(phase)
    turn = 0.4 * np.sin(clock * rate[0] * 0.5)
    return Course(place + sway, heading + turn)


def headings(position: Floats) -> Floats:
    """Return the direction of motion at each of (steps, 2) places, rad."""
    if len(position) < 2:
        return np.zeros(len(position))
    ahead = np.diff(position, axis=0)
    angle = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    return np.concatenate([angle, angle[-1:]])


def _dense(corners: Floats) -> tuple[Floats, Floats]:
    """Return a polyline's points at even distances, and its direction there."""
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(length)])
    at = np.linspace(0, distance[-1], max(round(distance[-1] / _STEP_M), 2) + 1)
    points = np.stack([np.interp(at, distance, corners[:, axis]) for axis in (0, 1)], axis=1)
    return points, headings(points)


def _smoothed(points: Floats) -> Floats:
    """Round off corners; the ends stay."""
    half = min(8, (len(points) - 1) // 2)
    padded = np.pad(points, ((half, half), (0, 0)), mode='edge')
    kernel = np.full(2 * half + 1, 1 / (2 * half + 1))
    smooth = np.stack([np.convolve(padded[:, axis], kernel, 'valid') for axis in (0, 1)], axis=1)
    smooth[[0, -1]] = points[[0, -1]]
    return smooth
