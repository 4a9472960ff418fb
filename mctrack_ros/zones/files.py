"""Zones and lines read from a site YAML, and written back into it."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml

from mctrack_ros.config import ConfigError, config_from, parameter
from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.coverage.field_of_view import polygon_from
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.zones.shapes import MOST, MOST_POINTS, PROBABILITY, Line, Point, Zone, Zones

BLOCKS = ('zones', 'lines')
"""Keys of a site YAML that this module reads and writes."""
_LONGEST_NAME = 64
_BY_HAND = 'zones and lines cannot be exchanged in it: write them by hand'


@dataclass(frozen=True, slots=True)
class LineSettings:
    """What a line of a site YAML has beside its points."""

    probability: float = parameter(
        PROBABILITY,
        'probability from which a track counts as on a side',
        minimum=0.5,
        maximum=0.999999,
    )


@dataclass(frozen=True, slots=True)
class ZoneSettings(LineSettings):
    """What a zone of a site YAML has beside its corners."""

    dwell_s: float = parameter(
        0.0,
        'time in the zone after which an event says that a track dwells; 0: none does [s]',
        minimum=0.0,
    )
    limit: int = parameter(
        0,
        'number above which an event says that the zone is crowded; 0: none does',
        minimum=0,
        maximum=1_000_000,
    )


def zones_from(content: Mapping[str, Any]) -> Zones:
    """
    Read the zones and lines of a site's nested values.

    Parameters
    ----------
    content : mapping
        Of the site; its keys ``zones`` and ``lines`` are mappings by name and may be absent.

    Raises
    ------
    ConfigError
        If a value is wrong; names the key.

    """
    blocks = [content.get(block) for block in BLOCKS]
    given: list[Mapping[Any, Any]] = []
    for block, values in zip(BLOCKS, blocks):
        if not isinstance(values, Mapping | None):
            raise ConfigError(f'{block} is {values!r:.60}, expected a mapping by name')
        given.append(values or {})
    zones, lines = given
    if len(zones) + len(lines) > MOST:
        raise ConfigError(
            f'zones and lines are {len(zones) + len(lines)}, expected at most {MOST} together'
        )
    twice = [name for name in zones if name in lines]
    if twice:
        raise ConfigError(f'zones.{twice[0]}: a line has the same name')
    return Zones(
        tuple(_zone(name, values) for name, values in zones.items()),
        tuple(_line(name, values) for name, values in lines.items()),
    )


def read_zones(path: str | Path) -> Zones:
    """
    Read the zones and lines of a site YAML alone, in the coordinates of its files.

    Raises
    ------
    ConfigError
        If the file cannot be read or a value is wrong; names file and key.

    """
    try:
        return zones_from(_mapping(read_yaml_file(path, ConfigError)))
    except ConfigError as error:
        raise ConfigError(_with_path(path, error)) from error


def save_zones(path: str | Path, zones: Zones) -> None:
    """
    Write zones and lines into a site YAML, in place of those in it.

    Only the blocks ``zones`` and ``lines`` change, with the comments in them; all other lines of
    the file stay as they are. The file is replaced at once: whoever reads it meanwhile finds the
    old or the new one.

    Parameters
    ----------
    path : str or Path
        The file.
    zones : Zones
        In the coordinates of the site's files.

    Raises
    ------
    ConfigError
        If a zone or line is wrong or the file cannot be read or written; then it stays as it is.

    """
    path = Path(path).resolve()
    values = {
        'zones': {each.name: _zone_values(each) for each in zones.zones},
        'lines': {each.name: _line_values(each) for each in zones.lines},
    }
    try:
        if any(len(values[block]) < len(getattr(zones, block)) for block in BLOCKS):
            raise ConfigError('two zones or two lines have the same name')
        zones_from(values)
        before = _mapping(read_yaml_file(path, ConfigError))
        with path.open(encoding='utf-8', newline='') as file:
            text = file.read()
        for block in BLOCKS:
            text = _with_block(text, block, values[block])
        _check_same(before, zones, text)
        _replace(path, text)
    except ConfigError as error:
        raise ConfigError(_with_path(path, error)) from error
    except OSError as error:
        raise ConfigError(f'{path}: {error.strerror or error}') from error
    except yaml.YAMLError as error:  # an alias of what stood in the blocks
        raise ConfigError(f'{path}: {_BY_HAND}') from error


def _zone(name: Any, values: Any) -> Zone:
    key = _key('zones', name)
    points, settings = _parts(key, values, 'corners', 3)
    try:
        polygon_from(points, f'{key}.corners')
    except CalibrationError as error:
        raise ConfigError(str(error)) from error
    own = config_from(ZoneSettings, settings, f'{key}.')
    return Zone(name, points, own.dwell_s, own.limit, own.probability)


def _line(name: Any, values: Any) -> Line:
    key = _key('lines', name)
    points, settings = _parts(key, values, 'points', 2)
    if len(set(points)) < len(points) - (points[0] == points[-1]) or len(set(points)) < 2:
        raise ConfigError(f'{key}.points has a point twice')
    if not shapely.LineString(points).is_simple:
        raise ConfigError(f'{key}.points: the line crosses or touches itself')
    return Line(name, points, config_from(LineSettings, settings, f'{key}.').probability)


def _key(block: str, name: Any) -> str:
    """Return how messages call a zone or line."""
    is_name = isinstance(name, str) and name.isprintable() and name == name.strip() != ''
    if not is_name or len(name) > _LONGEST_NAME:
        raise ConfigError(
            f'{block}: the name {name!r:.80} is none, expected up to {_LONGEST_NAME} printable '
            'characters, in quotes if they mean something else to YAML'
        )
    return f'{block}.{name}'


def _parts(
    key: str, values: Any, points_key: str, least: int
) -> tuple[tuple[Point, ...], dict[str, Any]]:
    """Return the points of a zone or line, and its settings."""
    if not isinstance(values, Mapping):
        raise ConfigError(f'{key} is {values!r:.60}, expected a mapping with {points_key}')
    settings = dict(values)
    given = settings.pop(points_key, None)
    if not isinstance(given, list) or not least <= len(given) <= MOST_POINTS:
        found = f'has {len(given)} points' if isinstance(given, list) else f'is {given!r:.60}'
        raise ConfigError(
            f'{key}.{points_key} {found}, expected {least} to {MOST_POINTS} points x, y in m'
        )
    return tuple(_point(f'{key}.{points_key}', each) for each in given), settings


def _point(key: str, given: Any) -> Point:
    """Return a point of a list."""
    numbers = given if isinstance(given, list) else []
    if len(numbers) != 2 or any(
        isinstance(each, bool) or not isinstance(each, int | float) for each in numbers
    ):
        raise ConfigError(f'{key} holds {given!r:.60}, expected points x, y in m')
    try:
        x, y = map(float, numbers)
    except OverflowError:
        x = y = np.inf
    if not np.isfinite([x, y]).all():
        raise ConfigError(f'{key} holds {given!r:.60}, expected finite numbers')
    return x, y


def _mapping(content: Any) -> Mapping[str, Any]:
    if not isinstance(content, Mapping):
        raise ConfigError('expected a mapping with the key cameras')
    return content


def _with_path(path: str | Path, error: ConfigError) -> str:
    reason = str(error)
    return reason if reason.startswith(f'{path}: ') else f'{path}: {reason}'


def _zone_values(zone: Zone) -> dict[str, Any]:
    values: dict[str, Any] = {'corners': [list(map(float, point)) for point in zone.corners]}
    return values | _unusual(zone, ('dwell_s', 'limit', 'probability'))


def _line_values(line: Line) -> dict[str, Any]:
    values: dict[str, Any] = {'points': [list(map(float, point)) for point in line.points]}
    return values | _unusual(line, ('probability',))


def _unusual(shape: Zone | Line, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the settings that differ from their defaults."""
    defaults = ZoneSettings()
    return {
        name: getattr(shape, name)
        for name in names
        if getattr(shape, name) != getattr(defaults, name)
    }


def _with_block(text: str, block: str, values: Mapping[str, Any]) -> str:
    """Return the text of a YAML mapping with one of its keys exchanged, added or taken out."""
    root = yaml.compose(text, yaml.SafeLoader)
    if not isinstance(root, yaml.MappingNode) or root.flow_style:
        raise ConfigError('its keys do not stand on lines of their own: zones cannot be written')
    lines = text.splitlines(keepends=True)
    ending = '\r\n' if lines and lines[0].endswith('\r\n') else '\n'
    new = _block_lines(block, values, ending)
    for key, value in root.value:
        if key.value == block:
            start, stop = key.start_mark.line, max(_last_line(key), _last_line(value)) + 1
            return ''.join([*lines[:start], *new, *lines[stop:]])
    stop = _last_line(root) + 1
    if new and not lines[stop - 1].endswith(('\n', '\r')):
        lines[stop - 1] += ending
    return ''.join([*lines[:stop], *new, *lines[stop:]])


def _block_lines(block: str, values: Mapping[str, Any], ending: str) -> list[str]:
    """Return the lines of a key of a site YAML, none if it has no values."""
    if not values:
        return []
    stream = io.StringIO()
    yaml.safe_dump(
        {block: dict(values)},
        stream,
        default_flow_style=None,
        sort_keys=False,
        allow_unicode=True,
        width=99,
    )
    return [line + ending for line in stream.getvalue().splitlines()]


def _last_line(node: yaml.Node) -> int:
    """Return the last line of a node, without what follows a block."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        parts = last if isinstance(last, tuple) else (last,)
        return max(_last_line(part) for part in parts)
    end = node.end_mark
    ends_before = end.column == 0 and end.line > node.start_mark.line
    return int(end.line) - int(ends_before)


def _check_same(before: Mapping[str, Any], zones: Zones, text: str) -> None:
    """Refuse a text that says something else of the rest of the site, or other zones."""
    after = _mapping(yaml.safe_load(text))
    rest = [
        {key: value for key, value in content.items() if key not in BLOCKS}
        for content in (before, after)
    ]
    if rest[0] != rest[1] or zones_from(after) != zones:
        raise ConfigError(_BY_HAND)


def _replace(path: Path, text: str) -> None:
    """Write a file at once, with the rights of the one in its place."""
    handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    try:
        with os.fdopen(handle, 'w', encoding='utf-8', newline='') as file:
            file.write(text)
        os.chmod(name, path.stat().st_mode & 0o7777)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise
