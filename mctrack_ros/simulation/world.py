"""All that is the same for every camera: who is where, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.appearance import Appearance, dressed
from mctrack_ros.simulation.cameras import Camera, pitch5_cameras
from mctrack_ros.simulation.intent import PLAYERS
from mctrack_ros.simulation.players import Motion, simulate_motion
from mctrack_ros.simulation.scenario import Scenario


@dataclass(frozen=True, eq=False, slots=True)
class World:
    """
    A whole match before it is seen.

    Attributes
    ----------
    scenario : Scenario
        What it was made from.
    motion : Motion
        Positions and poses at every step.
    appearance : Appearance
        Looks.
    cameras : tuple of Camera
        In the site's order.
    feet_in_view : (steps, cameras, n) bool array
        Whether a person's place on the ground is in a camera's picture.

    """

    scenario: Scenario
    motion: Motion
    appearance: Appearance
    cameras: tuple[Camera, ...]
    feet_in_view: NDArray[np.bool_]

    @classmethod
    def simulated(cls, scenario: Scenario) -> World:
        """Return the world that a scenario describes."""
        return cls.of(scenario, simulate_motion(scenario))

    @classmethod
    def of(cls, scenario: Scenario, motion: Motion) -> World:
        """Return the world in which people move as given."""
        cameras = pitch5_cameras(scenario)
        flat = np.zeros((*motion.position.shape[:2], 1))
        feet = np.concatenate([motion.position, flat], axis=2)
        in_view = np.stack([camera.sees(feet) for camera in cameras], axis=1)
        return cls(scenario, motion, dressed(scenario), cameras, in_view)

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Return the true ids of all people, (n,), from 1."""
        return np.arange(1, PLAYERS + 1, dtype=np.uint32)
