"""
TRACAB: ``frame:team,target,jersey,x,y,speed;...:x,y,z,speed,owner,state;:`` a line, and metadata.

Whole centimetres from the centre spot, x along the pitch; team 1 is at home, 0 away.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from mctrack_ros.input_size import SETTINGS, check_size
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

_HOME, _AWAY, _ABSENT = 1, 0, 4
_NOBODY = f'{_ABSENT},0,-1,5550,4400,0.00;'
_NO_BALL = (5550, 4400)
"""Where targets stand that are not there, cm; so do balls that nobody tracks."""
_TIME = '%Y-%m-%d %H:%M:%S'


class TracabWriter(CollectingWriter):
    """
    Write ``NAME.dat`` and ``NAME_metadata.xml``.

    Jersey and target are the id. Possession is not known: it is H in all frames, all of which are
    alive; the ball stands outside the pitch in frames in which none is tracked.
    """

    def _finish(self, rows: Collected) -> None:
        pitch, teams = self._layout.on_pitch(), teams_of(rows, self._layout)
        frame = self._layout.frame(rows.stamp_ns)
        with self._path.open('w', newline='\n') as file:
            file.writelines(_lines(rows, frame, teams, pitch))
        first, last = (int(frame[0]), int(frame[-1])) if len(frame) else (1, 1)
        root = Element('TracabMetaData', sVersion='1.0')
        began = int(self._layout.stamp_ns(np.array(first))) // 10**9
        match = add(
            root,
            'match',
            iId=1,
            dtDate=datetime.fromtimestamp(began, UTC).strftime(_TIME),
            iFrameRateFps=round(self._layout.rate_hz),
            fPitchXSizeMeters=f'{pitch.length:.2f}',
            fPitchYSizeMeters=f'{pitch.width:.2f}',
        )
        add(match, 'period', iId=1, iStartFrame=first, iEndFrame=last)
        if teams.home and teams.away:
            for name, number, ids in (('Home', 1, teams.home), ('Away', 2, teams.away)):
                team = add(root, f'{name}Team')
                add_texts(team, LongName=name, ShortName=name, TeamId=number)
                _describe_players(add(team, 'Players'), ids, rows, frame)
        write_xml(metadata_file(self._path), root)


def _describe_players(players: Element, ids: Iterable[int], rows: Collected, frame: Ints) -> None:
    """Add the players of a team."""
    tracks = rows.by_track()
    for who in ids:
        add_texts(
            add(players, 'Player'),
            PlayerId=who,
            FirstName='Track',
            LastName=f'#{who}',
            JerseyNo=who,
            StartFrameCount=frame[tracks[who][0]],
            EndFrameCount=frame[tracks[who][-1]],
        )


def _lines(rows: Collected, frame: Any, teams: Teams, pitch: Pitch) -> Iterator[str]:
    """Yield a line for every frame from the first to the last."""
    if not len(rows):
        return
    away, ball = set(teams.away), set(teams.ball)
    places = np.rint(100 * pitch.from_ground(rows.position[:, :2])).astype(np.int64).tolist()
    heights = np.rint(100 * rows.position[:, 2]).astype(np.int64).tolist()
    speeds, ids = np.hypot(*rows.velocity.T).tolist(), rows.track_id.tolist()
    numbers = np.arange(frame[0], frame[-1] + 2)
    bounds = np.searchsorted(frame, numbers).tolist()
    for number, start, end in zip(numbers.tolist(), bounds, bounds[1:]):
        targets, seen = [], f'{_NO_BALL[0]},{_NO_BALL[1]},0,0.00'
        for row in range(start, end):
            who, (x, y) = ids[row], places[row]
            if who in ball:
                seen = f'{x},{y},{heights[row]},{speeds[row]:.2f}'
            else:
                team = _AWAY if who in away else _HOME
                targets.append(f'{team},{who},{who},{x},{y},{speeds[row]:.2f};')
        yield f'{number}:{"".join(targets) or _NOBODY}:{seen},H,Alive;:\n'


def read_tracab(path: str | Path, layout: Layout) -> list[Tracks]:
    """
    Read TRACAB's text with its metadata beside it, ``NAME_metadata.xml`` or ``.json``.

    Target numbers become ids, the ball has the next one. Names, jerseys and teams are lost. The
    pitch lies as the layout says; unless it does, a corner of it is the origin.

    Raises
    ------
    TableError
        If it cannot be used; names file, line and reason.

    """
    path = Path(path)
    length, width, rate, date = _metadata(metadata_file(path, ('.xml', '.json')))
    rows = rows_of_lines(path, _read_line)
    if not rows:
        return []
    table = np.array(rows)
    frame, is_ball = table[:, 0].astype(np.int64), np.isnan(table[:, 1])
    ball_id = 1 + int(table[~is_ball, 1].max()) if not is_ball.all() else 1
    track_id = np.where(is_ball, ball_id, table[:, 1])
    began_ns = _stamp_ns(date) if date else layout.origin_ns
    stamps = began_ns + np.rint((frame - frame.min()) * (1e9 / rate)).astype(np.int64)
    pitch = layout.pitch_of(length, width)
    return instants_on_pitch(stamps, track_id, table[:, 2:] * 0.01, ball_id, pitch, layout)


def _read_line(line: str) -> Iterator[tuple[float, ...]]:
    """Yield frame, target, x, y and z, cm, of everybody in a line; the ball's target is NaN."""
    parts = line.split(':')
    if len(parts) < 3:
        raise ValueError('expected frame:targets:ball:')
    frame = float(int(parts[0]))
    for target in filter(None, parts[1].split(';')):
        team, who, _, x, y, *_ = target.split(',')
        if int(team) != _ABSENT:
            yield frame, float(int(who)), float(x), float(y), 0.0
    ball = [float(text) for text in parts[2].split(',')[:3]]
    if len(ball) == 3 and np.isfinite(ball).all() and tuple(ball[:2]) != _NO_BALL:
        yield frame, math.nan, *ball


def _metadata(path: Path) -> tuple[float, float, float, str]:
    """Return length and width, m, frames a second and date of any form of metadata."""
    check_size(path, SETTINGS, TableError)
    try:
        if path.suffix.lower() == '.json':
            flat: dict[str, Any] = json.loads(path.read_text(encoding='utf-8-sig'))
        else:
            root = read_xml(path)
            match = root.find('match')
            if match is not None:
                said = {name: text.replace(',', '.') for name, text in match.attrib.items()}
                sizes = said['fPitchXSizeMeters'], said['fPitchYSizeMeters']
                return (
                    _size(sizes[0]), _size(sizes[1]), _size(said['iFrameRateFps']),
                    said.get('dtDate', ''),
                )  # fmt: skip
            flat = {child.tag: child.text for child in root}
        sides = _size(flat['PitchLongSide']) / 100, _size(flat['PitchShortSide']) / 100
        return *sides, _size(flat['FrameRate']), str(flat.get('Kickoff') or '')
    except (OSError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise TableError(f'{path} is no metadata of TRACAB: {error!r}') from error


def _size(text: object) -> float:
    value = float(str(text))
    if not value > 0:
        raise ValueError(f'{text} where more than 0 is expected')
    return value


def _stamp_ns(date: str) -> int:
    try:
        return int(datetime.strptime(date, _TIME).replace(tzinfo=UTC).timestamp()) * 10**9
    except ValueError as error:
        raise TableError(f'the date {date!r} is not like 2026-05-31 20:45:00') from error
