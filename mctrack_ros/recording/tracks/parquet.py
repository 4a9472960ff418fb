"""Tracks as a Parquet file: every column of `/tracks`, without loss."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from mctrack_ros.input_size import TABLE, check_size
from mctrack_ros.interfaces import REPORTED, ClassCode, Tracks, TrackStatus
from mctrack_ros.recording.closing import Closing
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.collected import Layout, instants_of

_UPPER, _RIGHT = np.triu_indices(4)
_STATE = ('x', 'y', 'vx', 'vy')
_VARIANCES = [f'variance_{_STATE[row]}{_STATE[to]}' for row, to in zip(_UPPER, _RIGHT)]
_PLAIN = ('group', 'age', 'score', 'cameras', 'member_count', 'kit')
_ENUMS: dict[str, type[TrackStatus | ClassCode]] = {'status': TrackStatus, 'class': ClassCode}
_JOINED = {
    'position': ('x', 'y', 'z'),
    'velocity': ('vx', 'vy'),
    'covariance': _VARIANCES,
    'extent': ('width', 'height'),
}
"""Columns of `Tracks` of which each part is a column of the file."""
_ROWS = 100_000
"""Of a row group."""


def pyarrow_for(path: str | Path) -> tuple[ModuleType, ModuleType]:
    """Return pyarrow and its Parquet; TableError: it is not there, or not for this numpy."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise TableError(f'{path} needs pyarrow (17 for numpy 1): {error}') from error
    return pyarrow, parquet


class ParquetWriter(Closing):
    """
    Write the confirmed, coasting and grouped tracks, a row each; text for status and class.

    Parameters
    ----------
    path : str or Path
        The file, replaced if it is there; its parents are made.
    layout : Layout
        How it is laid out.

    """

    def __init__(self, path: str | Path, layout: Layout) -> None:
        self._arrow, parquet = pyarrow_for(path)
        self._layout = layout
        self._waiting: list[Tracks] = []
        self._rows = 0
        empty = self._table([Tracks.build(0)])
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        self._file = parquet.ParquetWriter(path, empty.schema)

    def write(self, rows: Tracks) -> None:
        """Append one instant."""
        self._waiting.append(rows.select(np.isin(rows.status, REPORTED)))
        self._rows += len(rows)
        if self._rows >= _ROWS:
            self._flush()

    def close(self) -> None:
        """Finish the file."""
        if self._waiting:
            self._flush()
        self._file.close()

    def _flush(self) -> None:
        self._file.write_table(self._table(self._waiting))
        self._waiting, self._rows = [], 0

    def _table(self, instants: list[Tracks]) -> Any:
        rows = Tracks.joined(0, instants)
        position = rows.position.astype(np.float64) + np.array([*self._layout.origin, 0.0])
        covariance = rows.covariance[:, _UPPER, _RIGHT]
        stamps = np.array([each.stamp_ns for each in instants], np.int64)
        columns: dict[str, Any] = {
            'stamp_ns': np.repeat(stamps, [len(each) for each in instants]),
            'track_id': rows.track_id,
            **dict(zip('xyz', position.T)),
            **dict(zip(('vx', 'vy'), rows.velocity.T)),
            **dict(zip(_VARIANCES, covariance.T)),
            **dict(zip(('width', 'height'), rows.extent.T)),
            **{name: getattr(rows, name) for name in _PLAIN},
        }
        made = {name: self._arrow.array(values) for name, values in columns.items()}
        for name, codes in (('status', rows.status), ('class', rows.class_id)):
            texts = [_ENUMS[name](code).name.lower() for code in codes.tolist()]
            made[name] = self._arrow.array(texts, self._arrow.string())
        return self._arrow.table(made)


def read_parquet(path: str | Path, layout: Layout) -> list[Tracks]:
    """
    Read tracks from a Parquet file; only the stamp, id, x and y must be there.

    Raises
    ------
    TableError
        If it cannot be used; says why.

    """
    given = _read_columns(path)
    for name in ('stamp_ns', 'track_id', 'x', 'y'):
        if name not in given:
            raise TableError(f'{path} has no column {name}')
    given.setdefault('z', np.zeros(len(given['x'])))
    joined = {
        name: np.column_stack([given[part] for part in parts])
        for name, parts in _JOINED.items()
        if given.keys() >= set(parts)
    }
    columns: dict[str, Any] = {'track_id': given['track_id'], **joined}
    columns['position'] = joined['position'].astype(np.float64)
    if 'covariance' in joined:
        covariance = np.zeros((len(joined['covariance']), 4, 4), np.float32)
        covariance[:, _UPPER, _RIGHT] = joined['covariance']
        covariance[:, _RIGHT, _UPPER] = covariance[:, _UPPER, _RIGHT]
        columns['covariance'] = covariance
    columns |= {name: given[name] for name in _PLAIN if name in given}
    for name, column in (('status', 'status'), ('class', 'class_id')):
        if name in given:
            columns[column] = _codes(given[name], name, path)
    return instants_of(given['stamp_ns'].astype(np.int64), columns, layout.origin)


def _read_columns(path: str | Path) -> dict[str, Any]:
    """Return the columns of a file; names of states and classes as lists."""
    arrow, parquet = pyarrow_for(path)
    check_size(path, TABLE, TableError)
    try:
        table = parquet.read_table(path)
        return {
            name: table[name].to_numpy() if name not in _ENUMS else table[name].to_pylist()
            for name in table.column_names
        }
    except (OSError, arrow.ArrowException) as error:
        raise TableError(f'{path} cannot be read: {error}') from error


def _codes(names: list[str], column: str, path: str | Path) -> list[int]:
    known = {code.name.lower(): int(code) for code in _ENUMS[column]}
    for name in set(names) - known.keys():
        raise TableError(f'{path}: {column} is {name!r}, expected one of {", ".join(known)}')
    return [known[name] for name in names]
