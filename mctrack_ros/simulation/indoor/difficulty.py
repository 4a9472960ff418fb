"""How hard a recording of the room is."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from mctrack_ros.interfaces import Events
from mctrack_ros.simulation.difficulty import OCCLUDED_BELOW
from mctrack_ros.simulation.rendering.sight import View
from mctrack_ros.simulation.world import World

CLOSE_M = 0.8
"""People are close to one another within this distance, m."""


@dataclass(frozen=True, slots=True)
class IndoorDifficulty:
    """
    Figures of difficulty.

    Attributes
    ----------
    occluded_share : float
        Share of people in images of whom somebody in front hides at least 5 %.
    close_share : float
        Share of people's time with somebody within 0.8 m.
    least_distance_m : float
        Of two people, m.
    people_per_image : float
        Mean number of people in an image.

    """

    occluded_share: float
    close_share: float
    least_distance_m: float
    people_per_image: float

    def figures(self) -> dict[str, float]:
        """Return name -> number."""
        return asdict(self)


class IndoorMeter:
    """Count the difficulty of a world while its views are made."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._images = self._rows = self._occluded = 0

    def add(self, view: View, events: Events) -> None:
        """Count one image."""
        self._images += 1
        self._rows += len(view.person)
        self._occluded += int(np.count_nonzero(view.visible < OCCLUDED_BELOW))

    def result(self) -> IndoorDifficulty:
        """Return the figures of what was counted."""
        world = self._world
        apart = np.linalg.norm(
            world.motion.position[:, :, None] - world.motion.position[:, None], axis=3
        )
        both = world.active[:, :, None] & world.active[:, None]
        apart[~both | np.eye(len(world.class_id), dtype=np.bool_)] = np.inf
        nearest = apart.min(axis=2)[world.active]
        return IndoorDifficulty(
            occluded_share=self._occluded / max(self._rows, 1),
            close_share=float((nearest < CLOSE_M).mean()) if len(nearest) else 0.0,
            least_distance_m=float(nearest.min(initial=np.inf)),
            people_per_image=self._rows / max(self._images, 1),
        )
