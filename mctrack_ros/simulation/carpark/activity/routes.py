"""Where people walk: along lanes, pavement and footway, and across between parked cars."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark import layout

Floats = NDArray[np.float64]

CORRIDORS = (layout.PAVEMENT_Y, (6.0, 10.6), (22.2, 27.2), layout.FOOTWAY_Y)
"""Near and far edge of where people walk from side to side, m."""

_OUT_M = 1.5


class Routes:
    """
    Draw ways through what a camera sees.

    Parameters
    ----------
    camera : Camera
        People come into its image from outside and leave it.
    rng : Generator
        Draws places.

    """

    def __init__(self, camera: Camera, rng: np.random.Generator) -> None:
        self._camera, self._rng = camera, rng

    def half_width(self, y: float) -> float:
        """Return how far left and right of the middle the image reaches, m."""
        middle = layout.LENGTH_M / 2
        depth = float(self._camera.depth([middle, y, 0.0]))
        return self._camera.size[0] / 2 / self._camera.focal_px * depth

    def outside(self, corridor: int, side: int) -> Floats:
        """Return a place on a corridor beyond the image's left (-1) or right (+1) edge."""
        y = self._rng.uniform(*CORRIDORS[corridor])
        return np.array([layout.LENGTH_M / 2 + side * (self.half_width(y) + _OUT_M), y])

    def anywhere_outside(self) -> tuple[int, Floats]:
        """Return a corridor and a place on it beyond the image."""
        corridor = int(self._rng.integers(len(CORRIDORS)))
        return corridor, self.outside(corridor, int(self._rng.choice((-1, 1))))

    def inside(self, corridor: int, reach: float = 0.7) -> Floats:
        """Return a place on a corridor well inside the image."""
        y = self._rng.uniform(*CORRIDORS[corridor])
        half = reach * self.half_width(y)
        return np.array([layout.LENGTH_M / 2 + self._rng.uniform(-half, half), y])

    def between(self, start: Floats, end: Floats) -> Floats:
        """Return the corners of a way from one place to another, through a gap between cars."""
        middle = (start[0] + end[0]) / 2
        if _row_between(start[1], end[1]):
            x = self._gap_near(middle, min(start[1], end[1]))
            return np.array([start, (x, _clear(start[1])), (x, _clear(end[1])), end])
        if self._rng.random() < 0.4:
            return np.array([start, end])
        y = self._rng.uniform(*sorted((start[1], end[1])))
        bend = np.array([middle + self._rng.normal(scale=3.0), y])
        return np.array([start, bend, end])

    def _gap_near(self, x: float, y: float) -> float:
        """Return one of the gaps about a place that the image shows."""
        gaps = layout.gaps_x()
        seen = gaps[np.abs(gaps - layout.LENGTH_M / 2) < 0.85 * self.half_width(y)]
        weight = np.exp(-(((seen - x) / 8.0) ** 2))
        return float(self._rng.choice(seen, p=weight / weight.sum()))


def _row_between(one: float, other: float) -> bool:
    """Return whether parked cars stand between two distances from the camera."""
    low, high = min(one, other), max(one, other)
    return (low < 2.5 < high) or (low < 16.5 < high)


def _clear(y: float) -> float:
    """Return where somebody turns towards a gap: clear of the cars' ends."""
    low, high = min(CORRIDORS, key=lambda corridor: abs(sum(corridor) / 2 - y))
    return float(np.clip(y, low, high))
