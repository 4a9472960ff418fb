"""Tracks, or truth, as a table with a header: what MOT text cannot say is in it, too."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode, Tracks, TrackStatus
from mctrack_ros.recording.tables.class_names import CLASS_NAMES
from mctrack_ros.recording.tables.columns import TIMES, Spellings, Table, TableError, read_table
from mctrack_ros.recording.tracks.track_writer import TrackWriter

COLUMNS: Spellings = {
    **TIMES,
    'track_id': ('id', 'object_id', 'person_id', 'target_id', 'global_id'),
    'x': ('x_m', 'ground_x', 'world_x'),
    'y': ('y_m', 'ground_y', 'world_y'),
    'vx': ('velocity_x',),
    'vy': ('velocity_y',),
    'class': ('class_name', 'class_id', 'label', 'category', 'type'),
    'status': ('state',),
    'score': ('conf', 'confidence', 'probability'),
    'group': ('group_id',),
}
"""Columns that are read, each with other names for the same."""
_STATUS = {status.name.lower(): int(status) for status in TrackStatus}


class TrackTableWriter(TrackWriter):
    """Write a table whose times are exact to the nanosecond."""

    HEADER = 'time,frame,track_id,x,y,vx,vy,class,status,score,group\n'

    def _lines(self, frame: int, rows: Tracks, position: NDArray[np.float64]) -> Iterator[str]:
        seconds, rest = divmod(rows.stamp_ns, 10**9)
        for row in range(len(rows)):
            (x, y, _), (vx, vy) = position[row].tolist(), rows.velocity[row].tolist()
            yield (
                f'{seconds}.{rest:09d},{frame},{rows.track_id[row]},'
                f'{x:.4f},{y:.4f},{vx:.3f},{vy:.3f},'
                f'{ClassCode(rows.class_id[row]).name.lower()},'
                f'{TrackStatus(rows.status[row]).name.lower()},'
                f'{rows.score[row]:.3f},{rows.group[row]}\n'
            )


def read_track_table(
    path: str | Path, period_ns: int, origin: tuple[float, float] = (0.0, 0.0)
) -> tuple[list[Tracks], list[int], bool]:
    """
    Read tracks, or truth, from a table with a header.

    Parameters
    ----------
    path : str or Path
        The file; `COLUMNS` are read, at least time or frame, id, x and y.
    period_ns : int
        Period of its frames, ns, if it has no times.
    origin : (float, float)
        Origin of the returned positions, m.

    Returns
    -------
    instants : list of Tracks
        Ascending. Frames, from 1, are stamped with the middles of their periods.
    frames : list of int
        Number of each, where the file has frames beside times; else empty.
    counts_frames : bool
        Whether it has no times.

    Raises
    ------
    TableError
        If it cannot be used; names file, line and reason.

    """
    table = read_table(path, COLUMNS)
    for name in ('track_id', 'x', 'y'):
        if name not in table.cells:
            raise TableError(f'{path} has no column {name}')
    stamps, numbered = table.stamps_ns(), 'frame' in table.cells
    counts_frames = stamps is None
    frame = table.whole_numbers('frame', 1) if numbered else np.zeros(len(table), np.int64)
    if stamps is None:
        if not numbered:
            raise TableError(f'{path} has neither a column time nor frame')
        stamps = (frame - 1) * period_ns + period_ns // 2
    columns = _columns(table, origin)
    order = np.argsort(stamps, kind='stable')
    parts = np.split(order, np.flatnonzero(np.diff(stamps[order])) + 1)
    parts = [part for part in parts if len(part)]
    instants = [
        Tracks.build(
            int(stamps[part[0]]), **{name: values[part] for name, values in columns.items()}
        )
        for part in parts
    ]
    frames = [int(frame[part[0]]) for part in parts] if numbered and not counts_frames else []
    return instants, frames, counts_frames


def _columns(table: Table, origin: tuple[float, float]) -> dict[str, Any]:
    """Return the columns of `Tracks`, row by row; positions are relative to an origin, m."""
    columns: dict[str, Any] = {
        'track_id': table.whole_numbers('track_id', 0),
        'position': np.column_stack(
            [
                _filled(table, 'x') - origin[0],
                _filled(table, 'y') - origin[1],
                np.zeros(len(table)),
            ]
        ),
        'velocity': np.nan_to_num(np.column_stack([table.numbers('vx'), table.numbers('vy')])),
        'class_id': _codes(table),
        'status': _states(table),
        'score': np.nan_to_num(table.numbers('score'), nan=1.0),
    }
    if 'group' in table.cells:
        columns['group'] = table.whole_numbers('group', 0)
    return columns


def track_table_place(path: str | Path) -> tuple[float, float] | None:
    """Return the first position in a table, m; None if it has none. Raises `TableError`."""
    table = read_table(path, COLUMNS)
    places = np.column_stack([table.numbers('x'), table.numbers('y')])
    known = places[np.isfinite(places).all(axis=1)]
    return (float(known[0, 0]), float(known[0, 1])) if len(known) else None


def _filled(table: Table, name: str) -> NDArray[np.float64]:
    values = table.numbers(name)
    for row in np.flatnonzero(np.isnan(values)):
        raise table.error(row, f'{name} is empty')
    return values


def _codes(table: Table) -> NDArray[np.int64]:
    """Return classes, (n,); what is not known is `ClassCode.UNKNOWN`."""
    names = [text.lower() for text in table.texts('class')]
    return np.array([CLASS_NAMES.get(name, ClassCode.UNKNOWN) for name in names], np.int64)


def _states(table: Table) -> NDArray[np.int64]:
    """Return states, (n,); confirmed where nothing is said."""
    states = []
    for row, text in enumerate(table.texts('status')):
        if text and text.lower() not in _STATUS:
            raise table.error(row, f'status is {text!r}, expected one of {", ".join(_STATUS)}')
        states.append(_STATUS[text.lower() or 'confirmed'])
    return np.array(states, np.int64)
