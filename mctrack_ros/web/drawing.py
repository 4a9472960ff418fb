"""What the calibration page draws over the picture and on the plan: plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.web.pairing import Pairing

Floats = NDArray[np.float64]
Extent = tuple[float, float, float, float]
ARROW_SCALE = 10.0
"""How much longer than in truth residuals are drawn."""
LINES = 14
SAMPLES = 60
MARGIN = 0.12


@dataclass(frozen=True, slots=True)
class Line:
    """A line through (n, 2) `points`; `kind` says how it looks."""

    points: list[list[float]]
    kind: str


@dataclass(frozen=True, slots=True)
class Mark:
    """A point of the scene at (`x`, `y`); `kind` says how it looks, `movable` if it is dragged."""

    name: str
    x: float
    y: float
    kind: str
    movable: bool = False


@dataclass(frozen=True, slots=True)
class Drawing:
    """Lines, arrows (from the first of two points to the second) and marks."""

    lines: list[Line]
    arrows: list[Line]
    marks: list[Mark]

    def as_json(self) -> dict[str, Any]:
        """Return it as the browser takes it."""
        return asdict(self)


def picture_drawing(pairing: Pairing) -> Drawing:
    """
    Return what lies over the picture, px.

    The pairs, their residuals as arrows, and through the fitted camera the metre grid and the
    points that have no place yet.
    """
    suspicious = pairing.suspicious()
    marks = [
        Mark(name, x, y, _kind(pairing, name, suspicious), movable=True)
        for name, (x, y) in pairing.pairs.items()
    ]
    if pairing.waiting is not None:
        marks.append(Mark('?', *pairing.waiting, 'waiting'))
    if pairing.fit is None:
        return Drawing([], [], marks)
    width, height = pairing.image_size
    extent = (0.0, 0.0, float(width), float(height))
    lines = _cut(_metre_grid(pairing.ground), pairing.fit.mapping.image_from_ground, extent)
    arrows = [
        Line([seen.tolist(), (seen - ARROW_SCALE * residual).tolist()], 'residual')
        for seen, residual in zip(pairing.fit.image, pairing.fit.residual)
    ]
    return Drawing([Line(line, 'grid') for line in lines], arrows, _expected(pairing) + marks)


def plan_drawing(pairing: Pairing) -> Drawing:
    """Return the plan of the scene, x to the right and y upwards (negated), m."""
    suspicious, pairs = pairing.suspicious(), pairing.pairs
    marks = [
        Mark(name, x, -y, _kind(pairing, name, suspicious) if name in pairs else 'free')
        for name, (x, y) in zip(pairing.names, pairing.ground.tolist())
    ]
    chosen = [Mark(m.name, m.x, m.y, 'chosen') for m in marks if m.name == pairing.chosen]
    marks = [mark for mark in marks if mark.name != pairing.chosen] + chosen
    lines = [Line(_flipped(line).tolist(), 'metres') for line in _metre_grid(pairing.ground)]
    if pairing.fit is not None:
        low_x, low_y, width, height = plan_extent(pairing)
        edge = _picture_edge(pairing.image_size)
        mapping = pairing.fit.mapping
        seen = _cut(
            edge,
            lambda pixel: _flipped(mapping.ground_from_image(pixel)),
            (low_x, low_y, width, height),
        )
        lines += [Line(line, 'view') for line in seen]
    return Drawing(lines, [], marks)


def plan_extent(pairing: Pairing) -> Extent:
    """Return left, top, width and height of the plan, m, a margin about the points."""
    low, high = pairing.ground.min(axis=0), pairing.ground.max(axis=0)
    margin = MARGIN * max(float((high - low).max()), 1.0)
    width, height = (high - low + 2 * margin).tolist()
    return (float(low[0]) - margin, -float(high[1]) - margin, width, height)


def grid_step(ground: Floats) -> float:
    """Return the distance of the metre grid's lines, m: 1, 2 or 5 times a power of ten."""
    extent = max(float(np.ptp(ground, axis=0).max()), 1e-3)
    power = 10 ** np.floor(np.log10(extent / LINES))
    return float(next(power * s for s in (1, 2, 5, 10) if extent / (power * s) <= LINES))


def _kind(pairing: Pairing, name: str, suspicious: tuple[str, ...]) -> str:
    if name == pairing.chosen:
        return 'chosen'
    return 'suspicious' if name in suspicious else 'paired'


def _expected(pairing: Pairing) -> list[Mark]:
    """Return the points without a place where the fitted camera sees them in the picture."""
    assert pairing.fit is not None
    pairs, (width, height) = pairing.pairs, pairing.image_size
    pixels = pairing.fit.mapping.image_from_ground(pairing.ground).tolist()
    return [
        Mark(name, x, y, 'chosen-expected' if name == pairing.chosen else 'expected')
        for name, (x, y) in zip(pairing.names, pixels)
        if name not in pairs and 0 <= x <= width and 0 <= y <= height
    ]


def _metre_grid(ground: Floats) -> list[Floats]:
    """Return (n, 2) points along each line of a metre grid about the scene, m."""
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


def _picture_edge(image_size: tuple[int, int]) -> list[Floats]:
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]) * np.array(image_size)
    shares = np.linspace(0, 1, 4 * SAMPLES)[:, None]
    return [a + shares * (b - a) for a, b in pairwise(corners)]


def _flipped(points: Floats) -> Floats:
    flipped: Floats = points * np.array([1.0, -1.0])
    return flipped


def _cut(
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
