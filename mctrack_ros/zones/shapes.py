"""Zones and lines of a site, as its YAML names them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

Point = tuple[float, float]

MOST = 64
"""Zones and lines of a site together."""
MOST_POINTS = 100
"""Of a zone or a line."""
PROBABILITY = 0.99
"""From which on a track counts as on one side; see `mctrack_ros.zones.sides`."""


@dataclass(frozen=True, slots=True)
class Zone:
    """
    An area that tracks enter and leave.

    Attributes
    ----------
    name : str
        Unique among the zones and lines of a site.
    corners : tuple of (float, float)
        Of a polygon, around it either way, m.
    dwell_s : float
        After so long in it a track dwells, s; 0: no event says so.
    limit : int
        More than so many crowd it; 0: any number may be in it.
    probability : float
        From which on a track counts as inside, or as outside.

    """

    name: str
    corners: tuple[Point, ...]
    dwell_s: float = 0.0
    limit: int = 0
    probability: float = PROBABILITY


@dataclass(frozen=True, slots=True)
class Line:
    """
    A line that tracks cross, to its left or to its right.

    Attributes
    ----------
    name : str
        Unique among the zones and lines of a site.
    points : tuple of (float, float)
        From its beginning to its end, m: left is left of somebody who walks along it.
    probability : float
        From which on a track counts as on a side of it.

    """

    name: str
    points: tuple[Point, ...]
    probability: float = PROBABILITY


@dataclass(frozen=True, slots=True)
class Zones:
    """
    The zones and lines of a site. A row of events names them by index, from 1: zones first.

    Attributes
    ----------
    zones : tuple of Zone
        In the order of the site's file.
    lines : tuple of Line
        In the order of the site's file.

    """

    zones: tuple[Zone, ...] = ()
    lines: tuple[Line, ...] = ()

    def __len__(self) -> int:
        """Return how many zones and lines there are."""
        return len(self.zones) + len(self.lines)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all, in the order of their indices."""
        return tuple(each.name for each in self.zones) + tuple(each.name for each in self.lines)

    @property
    def levels(self) -> tuple[float, ...]:
        """Probability from which a side is decided, of each."""
        zones = [each.probability for each in self.zones]
        return (*zones, *(each.probability for each in self.lines))

    def moved(self, by: Point) -> Self:
        """Return the same elsewhere, moved by x, y in m."""
        return replace(
            self,
            zones=tuple(replace(each, corners=_moved(each.corners, by)) for each in self.zones),
            lines=tuple(replace(each, points=_moved(each.points, by)) for each in self.lines),
        )

    def described(self) -> list[dict[str, Any]]:
        """Return what `/site` says of them, in the order of their indices."""
        zones = [
            {
                'kind': 'zone',
                'name': each.name,
                'points': [list(point) for point in each.corners],
                'dwell_s': each.dwell_s,
                'limit': each.limit,
                'probability': each.probability,
            }
            for each in self.zones
        ]
        lines = [
            {
                'kind': 'line',
                'name': each.name,
                'points': [list(point) for point in each.points],
                'probability': each.probability,
            }
            for each in self.lines
        ]
        return [{'index': index, **each} for index, each in enumerate([*zones, *lines], start=1)]

    def configured(self) -> dict[str, Any]:
        """Return that as a part of a site's configuration, which sites without zones lack."""
        return {'zones': self.described()} if len(self) else {}

    @classmethod
    def from_description(cls, described: list[Mapping[str, Any]]) -> Self:
        """Return the zones and lines of what `/site` says of them."""
        zones = [
            Zone(
                each['name'],
                _points(each['points']),
                each['dwell_s'],
                each['limit'],
                each['probability'],
            )
            for each in described
            if each['kind'] == 'zone'
        ]
        lines = [
            Line(each['name'], _points(each['points']), each['probability'])
            for each in described
            if each['kind'] == 'line'
        ]
        return cls(tuple(zones), tuple(lines))


def _moved(points: tuple[Point, ...], by: Point) -> tuple[Point, ...]:
    return tuple((x + by[0], y + by[1]) for x, y in points)


def _points(points: list[list[float]]) -> tuple[Point, ...]:
    return tuple((float(x), float(y)) for x, y in points)
