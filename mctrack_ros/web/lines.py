"""Lines on the ground and over images: sampled, mapped, cut to what is shown."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Extent = tuple[float, float, float, float]
MARGIN = 0.12
"""How far beyond an extent lines go on, in its width and height."""
LINES = 14
SAMPLES = 60


def grid_step(ground: Floats) -> float:
    """Return the distance of the metre grid's lines, m: 1, 2 or 5 times a power of ten."""
    extent = max(float(np.ptp(ground, axis=0).max()), 1e-3)
    power = 10 ** np.floor(np.log10(extent / LINES))
    return float(next(power * s for s in (1, 2, 5, 10) if extent / (power * s) <= LINES))


def metre_grid(ground: Floats) -> list[Floats]:
    """Return (n, 2) points along each line of a metre grid about (m, 2) points, m."""
    step = grid_step(ground)
    low = np.floor(ground.min(axis=0) / step + 1e-9) * step
    high = np.ceil(ground.max(axis=0) / step - 1e-9) * step
    shares = np.linspace(0, 1, SAMPLES)[:, None]
    lines = []
    for axis in (0, 1):
        for value in np.arange(low[axis], high[axis] + step / 2, step).tolist():
            first, last = low.copy(), high.copy()
            first[axis] = last[axis] = value
            lines.append(first + shares * (last - first))
    return lines


def image_edge(image_size: tuple[int, int]) -> list[Floats]:
    """Return (n, 2) points along each side of an image, px."""
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]) * np.array(image_size)
    shares = np.linspace(0, 1, 4 * SAMPLES)[:, None]
    return [a + shares * (b - a) for a, b in pairwise(corners)]


def flipped(points: Floats) -> Floats:
    """Return (n, 2) ground positions with y downwards, as a drawing has it, or back."""
    turned: Floats = points * np.array([1.0, -1.0])
    return turned


def cut(
    lines: list[Floats], mapped: Callable[[Floats], Floats], extent: Extent
) -> list[list[list[float]]]:
    """Map lines and keep their parts within an extent (left, top, width, height)."""
    low = np.array(extent[:2]) - MARGIN * np.array(extent[2:])
    high = np.array(extent[:2]) + (1 + MARGIN) * np.array(extent[2:])
    pieces = []
    for line in lines:
        points = mapped(line)
        inside = ((points >= low) & (points <= high)).all(axis=1)
        breaks = np.flatnonzero(np.diff(inside)) + 1
        parts = zip(np.split(points, breaks), np.split(inside, breaks))
        pieces += [part.tolist() for part, kept in parts if kept[0] and len(part) > 1]
    return pieces
