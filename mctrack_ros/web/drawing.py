"""What the calibration page draws over the image and on the plan: plain numbers."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

from mctrack_ros.web.calibrate.pairing import Pairing
from mctrack_ros.web.lines import MARGIN, Extent, cut, flipped, image_edge, metre_grid

ARROW_SCALE = 10.0
"""How much longer than in truth residuals are drawn."""


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

    def moved(self, right: float, down: float) -> Drawing:
        """Return the drawing with all in it farther right and down."""

        def put(line: Line) -> Line:
            return replace(line, points=[[x + right, y + down] for x, y in line.points])

        marks = [replace(mark, x=mark.x + right, y=mark.y + down) for mark in self.marks]
        return Drawing([put(one) for one in self.lines], [put(one) for one in self.arrows], marks)

    def as_json(self) -> dict[str, Any]:
        """Return it as the browser takes it."""
        return asdict(self)


def image_drawing(pairing: Pairing) -> Drawing:
    """
    Return what lies over the image, px.

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
    lines = cut(metre_grid(pairing.ground), pairing.fit.mapping.image_from_ground, extent)
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
    lines = [Line(flipped(line).tolist(), 'metres') for line in metre_grid(pairing.ground)]
    if pairing.fit is not None:
        low_x, low_y, width, height = plan_extent(pairing)
        edge = image_edge(pairing.image_size)
        mapping = pairing.fit.mapping
        seen = cut(
            edge,
            lambda pixel: flipped(mapping.ground_from_image(pixel)),
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


def _kind(pairing: Pairing, name: str, suspicious: tuple[str, ...]) -> str:
    if name == pairing.chosen:
        return 'chosen'
    return 'suspicious' if name in suspicious else 'paired'


def _expected(pairing: Pairing) -> list[Mark]:
    """Return the points without a place where the fitted camera sees them in the image."""
    assert pairing.fit is not None
    pairs, (width, height) = pairing.pairs, pairing.image_size
    pixels = pairing.fit.mapping.image_from_ground(pairing.ground).tolist()
    return [
        Mark(name, x, y, 'chosen-expected' if name == pairing.chosen else 'expected')
        for name, (x, y) in zip(pairing.names, pixels)
        if name not in pairs and 0 <= x <= width and 0 <= y <= height
    ]
