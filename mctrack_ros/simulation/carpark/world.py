"""The car park as a world: everybody's course on the clock of the recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark.activity.cast import Actor
from mctrack_ros.simulation.carpark.activity.schedule import cast_of
from mctrack_ros.simulation.carpark.layout import carpark_cameras
from mctrack_ros.simulation.carpark.rendering.looks import shades
from mctrack_ros.simulation.carpark.scenario import CarParkScenario
from mctrack_ros.simulation.pitch.players import Motion
from mctrack_ros.simulation.rendering.appearance import Appearance
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.world import World, feet_in_view

PARKED_AFTER_S = 4.0
"""A car at rest for so long is parked: a tracker may take it for background (section 5)."""

_NOWHERE = (-500.0, -500.0)
_AT_REST_M = 1e-3


@dataclass(frozen=True, eq=False, slots=True)
class CarParkWorld(World):
    """
    A recording of the car park before it is seen.

    Attributes
    ----------
    present : (steps, n) bool array
        Who is there at all.
    party : (n,) int array
        People who come together are of one party (assumption 3 of section 3).
    size : (n, 3) array
        Length, width and height, m.

    """

    present: NDArray[np.bool_]
    party: NDArray[np.int64]
    size: NDArray[np.float64]

    @property
    def extent(self) -> NDArray[np.float64]:
        """Return everybody's width and height, (n, 2) m."""
        return self.size[:, 1:]


def carpark_world(scenario: CarParkScenario) -> CarParkWorld:
    """Return the world of a scenario."""
    cameras = carpark_cameras(scenario)
    actors = cast_of(scenario, cameras[0])
    return staged(scenario, actors, cameras)


def staged(scenario: Scenario, actors: list[Actor], cameras: tuple[Camera, ...]) -> CarParkWorld:
    """Return the world in which actors do as given before cameras."""
    motion, present = _motion(scenario, actors)
    class_id = np.array([actor.class_id for actor in actors], np.uint8)
    parked = present & (class_id == ClassCode.VEHICLE) & _rested(motion.position, scenario)
    active = present & ~parked
    size = np.array([actor.size for actor in actors])
    palette = shades(actors, np.random.default_rng([scenario.seed, 12]))
    return CarParkWorld(
        scenario=scenario,
        motion=motion,
        appearance=Appearance(palette, size[:, 2], np.zeros(len(actors), np.uint8)),
        cameras=cameras,
        feet_in_view=feet_in_view(motion.position, cameras) & active[:, None],
        active=active,
        class_id=class_id,
        present=present,
        parked=parked,
        party=np.array([actor.party for actor in actors]),
        size=size,
    )


def _motion(scenario: Scenario, actors: list[Actor]) -> tuple[Motion, NDArray[np.bool_]]:
    """Return everybody's motion, and who is there at which step."""
    shape = (scenario.steps, len(actors))
    position = np.tile(_NOWHERE, (*shape, 1))
    velocity, present = np.zeros_like(position), np.zeros(shape, np.bool_)
    heading, stride = np.zeros(shape), np.zeros(shape)
    for index, actor in enumerate(actors):
        window = slice(actor.first, actor.last)
        place = actor.course.position
        moved = np.diff(place, axis=0, prepend=place[:1]) * scenario.rate_hz
        speed = np.linalg.norm(moved, axis=1)
        position[window, index], velocity[window, index] = place, moved
        heading[window, index], present[window, index] = actor.course.heading, True
        strides_hz = np.where(speed > 0.4, 0.7 + 0.12 * speed, 0)
        stride[window, index] = index + 2 * np.pi * np.cumsum(strides_hz) * scenario.period_s
    return Motion(position, velocity, heading, stride), present


def _rested(position: NDArray[np.float64], scenario: Scenario) -> NDArray[np.bool_]:
    """Return which of (steps, n, 2) have not moved for 4 s, or since the first step."""
    moves = np.linalg.norm(np.diff(position, axis=0), axis=2) > _AT_REST_M
    steps = np.arange(scenario.steps)[:, None]
    last = np.maximum.accumulate(np.where(np.pad(moves, ((1, 0), (0, 0))), steps, -1_000), axis=0)
    return np.asarray(steps - last > PARKED_AFTER_S * scenario.rate_hz)
