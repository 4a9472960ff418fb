"""People who come in through the door, gather, stay close and change places."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.indoor.layout import DOOR, LENGTH_M, WIDTH_M, indoor_cameras
from mctrack_ros.simulation.indoor.scenario import EMPTY_STEPS, IndoorScenario
from mctrack_ros.simulation.pitch.players import Motion
from mctrack_ros.simulation.rendering.appearance import Appearance
from mctrack_ros.simulation.rendering.bodies import Cloth
from mctrack_ros.simulation.world import World, feet_in_view

Floats = NDArray[np.float64]

_NOWHERE = (-500.0, -500.0)
_ENTER_EVERY_S = 1.2
_SPEED, _ACCELERATION = 1.3, 4.0
_ROOM_M, _PUSH = 0.7, 4.0
"""Distance below which people step aside."""
_LEAST_M = 0.4
"""People do not come nearer: shoulders are 0.45 m wide, bodies half as deep."""
_SPOTS_M = 0.75
"""Distance of the spots on which the group stands."""
_SWAP_S, _WANDER_S = (1.2, 2.6), (4.0, 7.0)
_EDGE_M = 0.9
_COLOURS = np.array(
    [
        *[(60, 60, 170), (150, 90, 40), (60, 140, 60), (40, 40, 45), (200, 200, 205)],
        *[(110, 100, 95), (70, 150, 200), (130, 60, 110), (90, 120, 140), (170, 160, 90)],
    ]
)
_SKIN = np.array([(150, 180, 225), (120, 150, 200), (70, 100, 150), (45, 65, 100)])
_HAIR = np.array([(20, 22, 28), (35, 55, 85), (90, 140, 180)])
_HEIGHT_M = (1.62, 1.90)


def indoor_world(scenario: IndoorScenario) -> World:
    """Return the world of a scenario."""
    motion, present = _motion(scenario)
    cameras = indoor_cameras(scenario)
    inside = ((motion.position >= 0) & (motion.position <= (LENGTH_M, WIDTH_M))).all(axis=2)
    active = present & inside
    return World(
        scenario=scenario,
        motion=motion,
        appearance=street_clothes(scenario.seed, scenario.people),
        cameras=cameras,
        feet_in_view=feet_in_view(motion.position, cameras) & active[:, None],
        active=active,
        parked=np.zeros_like(active),
        class_id=np.full(scenario.people, ClassCode.PERSON, np.uint8),
    )


def street_clothes(seed: int, count: int) -> Appearance:
    """Dress everybody for the street; two may well look alike."""
    rng = np.random.default_rng([seed, 23])
    palette = np.zeros((count, len(Cloth), 3))
    for person in palette:
        shirt, trousers = _COLOURS[rng.integers(len(_COLOURS), size=2)]
        person[Cloth.SHIRT] = person[Cloth.SLEEVE] = shirt * rng.uniform(0.8, 1.1)
        person[Cloth.SHORTS] = person[Cloth.SOCK] = trousers * rng.uniform(0.5, 0.9)
        person[Cloth.SLEEVE] *= 0.9
        person[Cloth.SHOE] = (30, 30, 34)
        person[Cloth.SKIN] = _SKIN[rng.integers(len(_SKIN))]
        person[Cloth.HAIR] = _HAIR[rng.integers(len(_HAIR))]
    height = rng.uniform(*_HEIGHT_M, count)
    colours = np.clip(np.round(palette), 0, 255).astype(np.uint8)
    return Appearance(colours, height, np.zeros(count, np.uint8))


def _motion(scenario: IndoorScenario) -> tuple[Motion, NDArray[np.bool_]]:
    """Return everybody's motion, and who is in the room at which step."""
    rng = np.random.default_rng([scenario.seed, 21])
    count, steps, period = scenario.people, scenario.steps, scenario.period_s
    first = EMPTY_STEPS + np.round(np.arange(count) * _ENTER_EVERY_S / period).astype(int)
    present = np.arange(steps)[:, None] >= first
    phase = rng.uniform(0, 2 * np.pi, count)
    group = _Group(count, rng)

    def walk(step: int, place: Floats) -> Floats:
        spots = group.spots(step * period, present[step])
        return np.clip(spots, (0.25, 0.25), (LENGTH_M - 0.25, WIDTH_M - 0.25))

    return walked(np.tile(np.array(DOOR), (count, 1)), phase, present, period, walk), present


def walked(
    place: Floats,
    phase: Floats,
    present: NDArray[np.bool_],
    period: float,
    targets: Callable[[int, Floats], Floats],
    limited: Callable[[Floats], Floats] = lambda place: place,
) -> Motion:
    """
    Return how people walk who step aside for one another.

    Parameters
    ----------
    place : (n, 2) array
        Where they begin, m.
    phase : (n,) array
        Phases of their gaits at first, rad.
    present : (steps, n) bool array
        Who is there.
    period : float
        Between steps, s.
    targets : callable
        Step and places, (n, 2) m, to where everybody wants to be.
    limited : callable
        Places to places where one can be, (n, 2) m.

    """
    steps, count = present.shape
    position, velocity = np.tile(_NOWHERE, (steps, count, 1)), np.zeros((steps, count, 2))
    heading, stride = np.zeros((steps, count)), np.zeros((steps, count))
    speed, facing = np.zeros((count, 2)), np.zeros(count)
    for step in range(steps):
        here = present[step]
        wanted = _walk(place, targets(step, place)) + _stepping_aside(place, here)
        change = np.clip(wanted - speed, -_ACCELERATION * period, _ACCELERATION * period)
        speed = np.where(here[:, None], speed + change, 0.0)
        place = limited(_apart(place + speed * period, here))
        pace = np.hypot(*speed.T)
        turn = np.angle(np.exp(1j * (np.arctan2(speed[:, 1], speed[:, 0]) - facing)))
        facing = facing + turn * np.clip(pace - 0.2, 0, 1) * min(4 * period, 1)
        phase = phase + 2 * np.pi * np.where(pace > 0.2, 0.7 + 0.12 * pace, 0) * period
        position[step, here], velocity[step, here] = place[here], speed[here]
        heading[step], stride[step] = facing, phase
    return Motion(position, velocity, heading, stride)


class _Group:
    """Spots around a centre that moves now and then; people change spots."""

    def __init__(self, count: int, rng: np.random.Generator) -> None:
        self._rng, self._spot = rng, rng.permutation(count)
        self._centre = np.array([LENGTH_M, WIDTH_M]) / 2
        self._offsets = self._arranged(count)
        self._swap_s = self._wander_s = 0.0

    def spots(self, time_s: float, here: NDArray[np.bool_]) -> Floats:
        """Return where everybody wants to be, (n, 2) m."""
        rng = self._rng
        if time_s >= self._wander_s:
            margin = _EDGE_M + np.abs(self._offsets).max(axis=0) * 0.5
            self._centre = rng.uniform(margin, np.array([LENGTH_M, WIDTH_M]) - margin)
            self._offsets = self._arranged(len(here))
            self._wander_s = time_s + rng.uniform(*_WANDER_S)
        if time_s >= self._swap_s and here.sum() >= 2:
            one, other = rng.choice(np.flatnonzero(here), 2, replace=False)
            self._spot[[one, other]] = self._spot[[other, one]]
            self._swap_s = time_s + rng.uniform(*_SWAP_S)
        return np.asarray(self._centre + self._offsets[self._spot])

    def _arranged(self, count: int) -> Floats:
        """Return spots of a grid of two rows, turned, (n, 2) m from its centre."""
        grid = np.stack([np.arange(count) // 2, np.arange(count) % 2], axis=1).astype(float)
        grid = (grid - grid.mean(axis=0)) * _SPOTS_M * self._rng.uniform(0.9, 1.3)
        angle = self._rng.uniform(0, 2 * np.pi)
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.asarray(grid @ turned.T)


def _walk(place: Floats, target: Floats) -> Floats:
    """Return the velocities that bring people to their targets, m/s."""
    gap = target - place
    distance = np.linalg.norm(gap, axis=1, keepdims=True)
    return np.asarray(gap / np.maximum(distance, 1e-9) * np.minimum(1.5 * distance, _SPEED))


def _stepping_aside(place: Floats, here: NDArray[np.bool_]) -> Floats:
    """Return the velocity that keeps people from walking through one another, m/s."""
    apart = place[:, None] - place[None]
    distance = np.linalg.norm(apart, axis=2)
    both = here[:, None] & here[None] & ~np.eye(len(place), dtype=np.bool_)
    push = np.where(both, np.maximum(_ROOM_M - distance, 0) / _ROOM_M * _PUSH, 0)
    around = apart + 0.6 * np.stack([-apart[..., 1], apart[..., 0]], axis=-1)  # pass on the right
    return np.asarray((around / np.maximum(distance, 0.05)[..., None] * push[..., None]).sum(1))


def _apart(place: Floats, here: NDArray[np.bool_]) -> Floats:
    """Return places at which no two people stand within one another."""
    both = here[:, None] & here[None] & ~np.eye(len(place), dtype=np.bool_)
    gap = place[:, None] - place[None]
    distance = np.linalg.norm(gap, axis=2)
    missing = np.where(both, np.maximum(_LEAST_M - distance, 0) / 2, 0)
    return np.asarray(
        place + (gap / np.maximum(distance, 0.05)[..., None] * missing[..., None]).sum(1)
    )
