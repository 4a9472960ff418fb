"""How hard a simulated match is, so that it cannot be made easy unnoticed."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import EventCode, Events
from mctrack_ros.simulation.pitch.intent import PLAYERS, TEAM
from mctrack_ros.simulation.rendering.sight import View
from mctrack_ros.simulation.world import World

OCCLUDED_BELOW = 0.95
"""Visible share below which somebody is partly occluded in an image."""

CLOSE_M = 1.5
"""People of one kit are close to each other within this distance, m."""


@dataclass(frozen=True, slots=True)
class Difficulty:
    """
    Figures of difficulty.

    Attributes
    ----------
    occluded_share : float
        Share of player-frames (one person in one image of one camera) with less than
        95 % of the person's pixels visible.
    merges_per_camera_minute : float
        True merges of blobs, per camera and minute.
    same_kit_close_share : float
        Share of player-time in which somebody of the same kit is within 1.5 m.
    players_per_image : float
        Mean number of people in an image.
    seen_share : float
        Share of player-time in which at least one camera sees the person.

    """

    occluded_share: float
    merges_per_camera_minute: float
    same_kit_close_share: float
    players_per_image: float
    seen_share: float

    def figures(self) -> dict[str, float]:
        """Return name -> number."""
        return asdict(self)


class DifficultyMeter:
    """Count the difficulty of a world while its views are made."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._images = self._rows = self._occluded = self._merges = 0

    def add(self, view: View, events: Events) -> None:
        """Count one image and what happened in it."""
        self._images += 1
        self._rows += len(view.person)
        self._occluded += int(np.count_nonzero(view.visible < OCCLUDED_BELOW))
        self._merges += int(np.count_nonzero(events.event == EventCode.MERGE))

    def result(self) -> Difficulty:
        """Return the figures of what was counted."""
        minutes = self._images * self._world.scenario.period_s / 60
        return Difficulty(
            occluded_share=self._occluded / max(self._rows, 1),
            merges_per_camera_minute=self._merges / max(minutes, 1e-9),
            same_kit_close_share=same_kit_close_share(self._world.motion.position),
            players_per_image=self._rows / max(self._images, 1),
            seen_share=float(self._world.feet_in_view.any(axis=1).mean()),
        )


def same_kit_close_share(position: NDArray[np.float64]) -> float:
    """Return the share of player-time with a team mate within 1.5 m, of (steps, n, 2) m."""
    mates = (TEAM[:, None] == TEAM[None]) & ~np.eye(PLAYERS, dtype=np.bool_)
    close = 0
    for places in position:
        distance = np.linalg.norm(places[:, None] - places[None], axis=2)
        close += int(((distance <= CLOSE_M) & mates).any(axis=1).sum())
    return close / max(len(position) * PLAYERS, 1)
