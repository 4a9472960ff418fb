"""All that is the same for every camera: who is where, and their appearance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera, pitch5_cameras
from mctrack_ros.simulation.pitch.intent import PLAYERS
from mctrack_ros.simulation.pitch.players import Motion, simulate_motion
from mctrack_ros.simulation.pitch.ptz import PtzCamera, PtzScenario, ptz_cameras
from mctrack_ros.simulation.rendering.appearance import Appearance, dressed
from mctrack_ros.simulation.scenario import Scenario


@dataclass(frozen=True, eq=False, slots=True)
class World:
    """
    All that happens before it is seen.

    Attributes
    ----------
    scenario : Scenario
        What it was made from.
    motion : Motion
        Positions and poses at every step.
    appearance : Appearance
        Looks.
    cameras : tuple of Camera or PtzCamera
        In the site's order.
    feet_in_view : (steps, cameras, n) bool array
        Whether an active one's place on the ground is in a camera's image.
    active : (steps, n) bool array
        Who is there to be tracked.
    parked : (steps, n) bool array
        Which cars have stood long enough to belong to the scene; they are not active.
    class_id : (n,) uint8 array
        A `ClassCode`.

    """

    scenario: Scenario
    motion: Motion
    appearance: Appearance
    cameras: tuple[Camera | PtzCamera, ...]
    feet_in_view: NDArray[np.bool_]
    active: NDArray[np.bool_]
    parked: NDArray[np.bool_]
    class_id: NDArray[np.uint8]

    @classmethod
    def simulated(cls, scenario: Scenario) -> World:
        """Return the world that a scenario describes."""
        return cls.of(scenario, simulate_motion(scenario))

    @classmethod
    def of(cls, scenario: Scenario, motion: Motion) -> World:
        """Return the world in which people move as given."""
        cameras = pitch_cameras(scenario)
        active = np.ones(motion.heading.shape, np.bool_)
        people = np.full(PLAYERS, ClassCode.PERSON, np.uint8)
        in_view = feet_in_view(motion.position, cameras)
        return cls(scenario, motion, dressed(scenario), cameras, in_view, active, ~active, people)

    def views(self, step: int) -> tuple[Camera, ...]:
        """Return the cameras as they are at a step."""
        return tuple(camera.at(step) for camera in self.cameras)

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Return everybody's true id, (n,), from 1."""
        return np.arange(1, len(self.class_id) + 1, dtype=np.uint32)

    @property
    def extent(self) -> NDArray[np.float64]:
        """Return everybody's width and height, (n, 2) m."""
        return np.column_stack([0.3 * self.appearance.height, self.appearance.height])


def pitch_cameras(scenario: Scenario) -> tuple[Camera | PtzCamera, ...]:
    """Return the cameras of a pitch: static ones, or those that pan, tilt and zoom."""
    if isinstance(scenario, PtzScenario):
        return ptz_cameras(scenario)
    return pitch5_cameras(scenario)


def feet_in_view(
    position: NDArray[np.float64], cameras: Sequence[Camera | PtzCamera]
) -> NDArray[np.bool_]:
    """Return the (steps, cameras, n) that say which camera sees which of (steps, n, 2) places."""
    feet = np.concatenate([position, np.zeros((*position.shape[:2], 1))], axis=2)
    return np.stack([camera.sees(feet) for camera in cameras], axis=1)
