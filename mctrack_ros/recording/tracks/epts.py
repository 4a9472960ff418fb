"""
FIFA's standard transfer format of electronic performance and tracking systems (EPTS).

``NAME_metadata.xml`` says which channels of which players stand where in the lines of a text.
Positions are centimetres from the centre spot, x along the pitch, as in FIFA's example.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.collected import (
    Collected,
    CollectingWriter,
    Ints,
    Layout,
    instants_on_pitch,
    rows_of_lines,
)
from mctrack_ros.recording.tracks.pitch import Pitch
from mctrack_ros.recording.tracks.teams import Teams, teams_of
from mctrack_ros.recording.tracks.xml import add, add_texts, metadata_file, read_xml, write_xml

_BLOCK_S = 60.0
"""Lines of so long have the same players: the metadata stay small, and so do the lines."""
_NAMESPACE = 'FIFADataTransferFormatEPTSNamespace/FIFADataTransferFormatEPTS'
_SENSORS = (
    ('position', 'Position', (('x', 'cm'), ('y', 'cm'), ('z', 'cm'))),
    ('speed', 'Speed', (('s', 'm/s'),)),
)
_PLAYER, _BALL = ('x', 'y', 's'), ('x', 'y', 'z')
_METRES = {'cm': 0.01, 'centimeter': 0.01, 'centimeters': 0.01}
_METRES |= {'m': 1.0, 'meter': 1.0, 'meters': 1.0}
_NORMALIZED = 'normalized'


@dataclass(slots=True)
class _Block:
    """First and last frame of lines with the same players."""

    first: int
    last: int
    players: tuple[int, ...]


class EptsWriter(CollectingWriter):
    """Write the text ``NAME.txt`` and ``NAME_metadata.xml``; a player's id is ``track_ID``."""

    def _finish(self, rows: Collected) -> None:
        pitch, teams = self._layout.on_pitch(), teams_of(rows, self._layout)
        frame = self._layout.frame(rows.stamp_ns)
        blocks: list[_Block] = []
        with self._path.open('w', newline='\n') as file:
            file.writelines(_lines(rows, frame, teams, pitch, self._layout, blocks))
        root = Element('main', {'xmlns:tns': _NAMESPACE})
        metadata = add(root, 'Metadata')
        self._describe_session(metadata, pitch, blocks)
        _describe_players(metadata, teams)
        specifications = add(root, 'DataFormatSpecifications')
        for block in blocks:
            _describe_lines(specifications, block)
        write_xml(metadata_file(self._path), root)

    def _describe_session(self, metadata: Element, pitch: Pitch, blocks: list[_Block]) -> None:
        """Add frame rate, time, period and pitch."""
        first, last = (blocks[0].first, blocks[-1].last) if blocks else (1, 1)
        began_ns = int(self._layout.stamp_ns(np.array(first)))
        began = f'{np.datetime64(began_ns, "ns")}Z'
        configuration = add(metadata, 'GlobalConfig')
        add_texts(
            configuration,
            FileDate=began,
            FileName=self._path.name,
            TrackingType='Optical',
            ProviderName='mctrack_ros',
            FrameRate=round(self._layout.rate_hz),
        )
        parameters = add(configuration, 'ProviderGlobalParameters')
        for name, value in (('first_half_start', first), ('first_half_end', last)):
            add_texts(add(parameters, 'ProviderParameter'), Name=name, Value=value)
        session = add(add(metadata, 'Sessions'), 'Session', id='session1')
        add_texts(session, SessionType='Match', Start=began)
        sides = {'Width': f'{pitch.length:g}', 'Height': f'{pitch.width:g}'}
        add_texts(add(session, 'FieldSize'), **sides)


def _describe_players(metadata: Element, teams: Teams) -> None:
    """Add teams, players, sensors, and the channels of each player."""
    described = add(metadata, 'Teams')
    for name in ('home', 'away'):
        add_texts(add(described, 'Team', id=name), Name=name.capitalize())
    players, away = add(metadata, 'Players'), set(teams.away)
    for who in teams.players:
        team = 'away' if who in away else 'home'
        player = add(players, 'Player', id=f'track_{who}', teamId=team)
        add_texts(player, Name=f'Track #{who}', ShirtNumber=who)
    _describe_sensors(metadata)
    channels_of = add(metadata, 'PlayerChannels')
    for who in teams.players:
        for channel_id in _PLAYER:
            names = {'channelId': channel_id, 'playerId': f'track_{who}'}
            add(channels_of, 'PlayerChannel', id=f'track_{who}_{channel_id}', **names)


def _describe_sensors(metadata: Element) -> None:
    """Add what measures, and its channels."""
    device = add(add(metadata, 'Devices'), 'Device', id='device1')
    add_texts(device, Name='mctrack_ros')
    sensors = add(device, 'Sensors')
    for sensor_id, name, channels in _SENSORS:
        sensor = add(sensors, 'Sensor', id=sensor_id)
        add_texts(sensor, Name=name)
        listed = add(sensor, 'Channels')
        for channel_id, unit in channels:
            channel = add(listed, 'Channel', id=channel_id)
            add_texts(channel, Name=f'{sensor_id}_{channel_id}', Unit=unit)


def _describe_lines(specifications: Element, block: _Block) -> None:
    """Add what stands where in the lines of a block."""
    line = add(
        specifications,
        'DataFormatSpecification',
        startFrame=block.first,
        endFrame=block.last,
        separator=':',
    )
    add(line, 'StringRegister', name='frameCount')
    people = add(line, 'SplitRegister', separator=';')
    for who in block.players:
        player = add(people, 'SplitRegister', separator=',')
        for channel_id in _PLAYER:
            add(player, 'PlayerChannelRef', playerChannelId=f'track_{who}_{channel_id}')
    ball = add(line, 'SplitRegister', separator=',')
    for channel_id in _BALL:
        add(ball, 'BallChannelRef', channelId=channel_id)


def _lines(
    rows: Collected,
    frame: Ints,
    teams: Teams,
    pitch: Pitch,
    layout: Layout,
    blocks: list[_Block],
) -> Iterator[str]:
    """Yield a line for every frame with rows; append what is in which lines to the blocks."""
    ball = set(teams.ball)
    places = np.round(100 * pitch.from_ground(rows.position[:, :2]), 1).tolist()
    heights = np.round(100 * rows.position[:, 2], 1).tolist()
    speeds, ids = np.hypot(*rows.velocity.T).tolist(), rows.track_id.tolist()
    length = round(_BLOCK_S * layout.rate_hz)
    for part in _parts((frame - 1) // length):
        players = tuple(sorted(set(rows.track_id[part].tolist()) - ball))
        first, last = int(frame[part[0]]), int(frame[part[-1]])
        if blocks and blocks[-1].players == players:
            blocks[-1].last = last
        else:
            blocks.append(_Block(first, last, players))
        for line in _parts(frame[part]):
            written, seen = dict.fromkeys(players, 'NaN,NaN,NaN'), 'NaN,NaN,NaN'
            for row in part[line].tolist():
                who, (x, y) = ids[row], places[row]
                if who in ball:
                    seen = f'{x},{y},{heights[row]}'
                else:
                    written[who] = f'{x},{y},{speeds[row]:.3f}'
            yield f'{frame[part[line[0]]]}:{";".join(written.values())}:{seen}\n'


def _parts(values: Ints) -> list[NDArray[np.intp]]:
    """Return the rows of each run of equal values."""
    if not len(values):
        return []
    return np.split(np.arange(len(values)), np.flatnonzero(np.diff(values)) + 1)


@dataclass(frozen=True, slots=True)
class _Metadata:
    """What the metadata say: sizes, m; the axes' units; names of players by their channels."""

    length: float
    width: float
    rate_hz: float
    began: str
    units: dict[str, str]
    channels: dict[str, tuple[str, str]]
    lines: list[tuple[int, int, Element]]

    def metres(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places, (n, 3) m from the centre spot, of those in the file's units."""
        unit = self.units.get('x', '').lower()
        if unit == _NORMALIZED:
            # the upper left corner is the origin, and y points down
            x, y = places[:, 0] - 0.5, 0.5 - places[:, 1]
            return np.column_stack([x * self.length, y * self.width, np.zeros(len(places))])
        if unit not in _METRES:
            known = ', '.join([*_METRES, _NORMALIZED])
            raise TableError(f'positions are in {unit!r}, expected {known}')
        return places * _METRES[unit]


def read_epts(path: str | Path, layout: Layout) -> list[Tracks]:
    """
    Read the text with the metadata beside it, ``NAME_metadata.xml``.

    The number at the end of a player's id is the track's, where these differ; otherwise players
    are numbered in the order of the metadata. The ball has the next number. Names, teams and
    further sensors are lost. The pitch lies as the layout says; unless it does, a corner of it is
    the origin.

    Raises
    ------
    TableError
        If it cannot be used; names file, line and reason.

    """
    path = Path(path)
    said = _read_metadata(metadata_file(path))
    numbers = _numbers(list(dict.fromkeys(who for who, _ in said.channels.values())))
    ball_id = 1 + max(numbers.values(), default=0)
    rows = rows_of_lines(path, lambda line: _read_line(line, said, numbers, ball_id))
    if not rows:
        return []
    table = np.array(rows)
    frame, place = table[:, 0].astype(np.int64), said.metres(table[:, 2:5])
    began_ns = int(np.datetime64(said.began, 'ns').astype(np.int64)) if said.began else 0
    stamps = began_ns + np.rint((frame - frame.min()) * 1e9 / said.rate_hz).astype(np.int64)
    pitch = layout.pitch_of(said.length, said.width)
    return instants_on_pitch(stamps, table[:, 1], place, ball_id, pitch, layout)


def _numbers(names: list[str]) -> dict[str, int]:
    """Return the tracks' ids of players."""
    ends = [re.search(r'(\d{1,9})$', name) for name in names]
    numbers = [int(end[1]) if end else 0 for end in ends]
    if 0 in numbers or len(set(numbers)) < len(numbers):
        numbers = list(range(1, len(names) + 1))
    return dict(zip(names, numbers))


def _read_line(
    line: str, said: _Metadata, numbers: dict[str, int], ball_id: int
) -> Iterator[tuple[float, ...]]:
    """Yield frame, id, x, y and z of everybody in a line, in the file's units."""
    frame = int(line.partition(':')[0])
    given = next((form for first, last, form in said.lines if first <= frame <= last), None)
    if given is None:
        return
    values = dict(_split(given, line))
    places: dict[int, dict[str, float]] = {}
    for name, text in values.items():
        who, channel = said.channels.get(name, (None, name.removeprefix('ball ')))
        if channel in _BALL and (who is not None or name.startswith('ball ')):
            number = ball_id if who is None else numbers[who]
            places.setdefault(number, {})[channel] = float(text or 'nan')
    for number, place in places.items():
        x, y, z = (place.get(axis, 0.0 if axis == 'z' else math.nan) for axis in 'xyz')
        if math.isfinite(x) and math.isfinite(y):
            yield float(frame), float(number), x, y, z if math.isfinite(z) else 0.0


def _split(form: Element, text: str) -> Iterator[tuple[str, str]]:
    """Yield channels and their texts in a part of a line."""
    separator = form.get('separator', '')
    for child, part in zip(form, text.rstrip(separator).split(separator)):
        if child.tag == 'SplitRegister':
            yield from _split(child, part)
        elif child.tag == 'PlayerChannelRef':
            yield child.get('playerChannelId', ''), part
        elif child.tag == 'BallChannelRef':
            yield f'ball {child.get("channelId")}', part


def _read_metadata(path: Path) -> _Metadata:
    root: Any = read_xml(path)
    try:
        field = root.find('Metadata/Sessions/Session/FieldSize')
        channels = root.iterfind('Metadata/Devices/Device/Sensors/Sensor/Channels/Channel')
        began = root.findtext('Metadata/Sessions/Session/Start', '')
        return _Metadata(
            float(field.findtext('Width')),
            float(field.findtext('Height')),
            float(root.findtext('Metadata/GlobalConfig/FrameRate')),
            began.strip().removesuffix('Z'),
            {channel.get('id'): channel.findtext('Unit', '').strip() for channel in channels},
            {
                each.get('id'): (each.get('playerId'), each.get('channelId'))
                for each in root.iterfind('Metadata/PlayerChannels/PlayerChannel')
            },
            [
                (int(form.get('startFrame')), int(form.get('endFrame')), form)
                for form in root.iterfind('DataFormatSpecifications/DataFormatSpecification')
            ],
        )
    except (AttributeError, TypeError, ValueError) as error:
        raise TableError(f'{path} is no metadata of EPTS: {error!r}') from error
