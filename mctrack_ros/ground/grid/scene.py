"""The scene of the event-tracking paper: named points on the ground, as XML (Algorithm 1)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mctrack_ros.ground.errors import SceneError
from mctrack_ros.ground.xml_files import read_checked, tag, write_lines

Scene = Mapping[str, tuple[float, float]]
"""Points on the ground by name: x and y, m."""


def read_scene(path: str | Path) -> dict[str, tuple[float, float]]:
    """
    Read a scene XML file; entities are refused.

    Returns
    -------
    dict of str to (float, float)
        x and y of each point, m, in the order of the file.

    Raises
    ------
    SceneError
        If the file cannot be read, breaks the schema or gives a name or a place twice; names
        file, line and reason.

    """
    points: dict[str, tuple[float, float]] = {}
    names: dict[tuple[float, float], str] = {}
    for point in read_checked(path, 'scene', SceneError):
        name, place = point.get('name'), (float(point.get('x')), float(point.get('y')))
        where = f'{path}:{point.sourceline}: point {name!r}'
        if name in points:
            raise SceneError(f'{where} is there twice')
        if place in names:
            raise SceneError(f'{where} lies where point {names[place]!r} does')
        points[name], names[place] = place, name
    return points


def write_scene(points: Scene, path: str | Path) -> None:
    """Write named points as a scene XML file, metres."""
    lines = [
        '  ' + tag('point', name=name, x=float(x), y=float(y)) for name, (x, y) in points.items()
    ]
    write_lines(path, ['<scene>', *lines, '</scene>'])
