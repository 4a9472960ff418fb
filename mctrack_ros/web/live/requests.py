"""What a browser may ask of the live map, and within which limits."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from mctrack_ros.zones.shapes import MOST, MOST_POINTS, PROBABILITY, Line, Zone, Zones

MOST_SIGNS = 100_000
"""Length of a request."""
MOST_CAMERAS = 6
"""Cameras that one window shows."""


class RequestError(ValueError):
    """A request that cannot be carried out; says why."""


@dataclass(frozen=True, slots=True)
class Live:
    """Show what happens."""


@dataclass(frozen=True, slots=True)
class At:
    """Show the past around a time, s since 1970."""

    time_s: float


@dataclass(frozen=True, slots=True)
class Show:
    """Send the images of these cameras."""

    cameras: frozenset[str]


@dataclass(frozen=True, slots=True)
class Find:
    """Say when a track was seen last, before a time, s since 1970."""

    track: int
    before_s: float


@dataclass(frozen=True, slots=True)
class Draw:
    """Save zones and lines, in the positions of `/tracks`."""

    zones: Zones


Request = Live | At | Show | Find | Draw


def request_from(text: str) -> Request:
    """
    Read a request.

    Raises
    ------
    RequestError
        If it is none, or too long.

    """
    if len(text) > MOST_SIGNS:
        raise RequestError('the request is too long')
    try:
        content = json.loads(text)
        kind = content['kind']
        if kind == 'live':
            return Live()
        if kind == 'at':
            return At(_time(content['time']))
        if kind == 'show':
            names = [str(name) for name in content['cameras']]
            return Show(frozenset(names[:MOST_CAMERAS]))
        if kind == 'find':
            return Find(_id(content['track']), _time(content['before']))
        if kind == 'draw':
            return Draw(_zones(content['shapes']))
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise RequestError('the request cannot be read') from error
    raise RequestError('the request is not known')


def _time(value: Any) -> float:
    time_s = float(value)
    if not (math.isfinite(time_s) and 0 <= time_s < 1e10):
        raise ValueError('no time')
    return time_s


def _id(value: Any) -> int:
    number = int(value)
    if not 0 < number < 2**32:
        raise ValueError('no id')
    return number


def _zones(shapes: list[dict[str, Any]]) -> Zones:
    """Read zones and lines; whether they make sense says who writes them."""
    if len(shapes) > MOST:
        raise RequestError(f'zones and lines: at most {MOST} together')
    zones, lines = [], []
    for shape in shapes:
        name, points = str(shape['name']).strip(), _points(shape['points'])
        probability = float(shape.get('probability', PROBABILITY))
        if shape['kind'] == 'line':
            lines.append(Line(name, points, probability))
        else:
            dwell_s, limit = float(shape.get('dwell_s', 0.0)), int(shape.get('limit', 0))
            zones.append(Zone(name, points, dwell_s, limit, probability))
    return Zones(tuple(zones), tuple(lines))


def _points(points: list[list[float]]) -> tuple[tuple[float, float], ...]:
    """Read points, to the centimetre."""
    if len(points) > MOST_POINTS:
        raise RequestError(f'a zone or line has at most {MOST_POINTS} points')
    return tuple((round(float(x), 2), round(float(y), 2)) for x, y in points)
