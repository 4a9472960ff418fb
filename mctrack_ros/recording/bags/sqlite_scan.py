"""SQLite bags that break off: read row by row, without their indices."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from array import array
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.rosbag2.metadata import parse_qos

from mctrack_ros.recording.bags.scan import Loss, Scan
from mctrack_ros.recording.errors import BagError

_HEADER = struct.Struct('>16xH6xII60xI')
"""Page size (65536 is written as 1), counter of changes, pages, counter when that was true."""
_JOURNALS = ('-wal', '-journal')
_FORMATS = {'ros2msg': MessageDefinitionFormat.MSG, 'ros2idl': MessageDefinitionFormat.IDL}
_ROWS = 'SELECT id, topic_id, timestamp, data FROM messages WHERE id >= ? ORDER BY id'
_IS_THERE = 'SELECT 1 FROM sqlite_master WHERE name = ?'
_NO_DEFINITION = MessageDefinition(MessageDefinitionFormat.NONE, '')


class SqliteScan(Scan):
    """
    All messages of a file that can be read; damaged pages are passed.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    BagError
        If the list of topics cannot be read.

    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._database = sqlite3.connect(f'{path.resolve().as_uri()}?immutable=1', uri=True)
        self._database.execute('PRAGMA writable_schema = ON')  # else a cut file is not opened
        try:
            topics = self._topics()
        except sqlite3.DatabaseError as error:
            self._database.close()
            raise BagError(f'its topics cannot be read: {error}') from error
        found = array('q')
        with suppress(sqlite3.DatabaseError):  # it breaks off there
            self._find(found)
            self.is_whole = True
        self._keep(found, 3, topics)

    def _data(self, *place: int) -> bytes:
        data: bytes = self._database.execute(
            'SELECT data FROM messages WHERE id = ?', place
        ).fetchone()[0]
        return data

    def _find(self, found: array[int]) -> None:
        """Add time, topic and number of all rows that can be read; note what is damaged."""
        first = 0
        while True:
            try:
                for number, topic, time_ns, _ in self._database.execute(_ROWS, (first,)):
                    found.extend((time_ns, topic, number))
                    first = number + 1
                return
            except sqlite3.DatabaseError:
                last_ns = found[-3] if found else 0
                number, time_ns = self._readable_from(first)
                self.losses.append(Loss(last_ns, time_ns, number - first))
                first = number

    def _readable_from(self, first: int) -> tuple[int, int]:
        """
        Return number and time of the next row, from a number that cannot be read on.

        Raises
        ------
        sqlite3.DatabaseError
            If there is none: the file breaks off.

        """
        (last,) = self._database.execute('SELECT max(id) FROM messages').fetchone()
        step = 1
        while (row := self._row_from(first + step)) is None:
            if first + step > last:
                raise sqlite3.DatabaseError('it breaks off')
            step *= 2
        damaged, sound = first + step // 2, first + step
        while damaged + 1 < sound:
            middle = (damaged + sound) // 2
            found = self._row_from(middle)
            if found is None:
                damaged = middle
            else:
                sound, row = middle, found
        return row

    def _row_from(self, number: int) -> tuple[int, int] | None:
        """Return number and time of the first row from a number on; None: it is damaged."""
        try:
            row = self._database.execute(f'{_ROWS} LIMIT 1', (number,)).fetchone()
        except sqlite3.DatabaseError:
            return None
        return None if row is None else (row[0], row[2])

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def _topics(self) -> list[Connection]:
        definitions: dict[str, MessageDefinition] = {}
        for row in self._rows('SELECT * FROM message_definitions'):
            kind = _FORMATS.get(row['encoding'], MessageDefinitionFormat.NONE)
            text = row['encoded_message_definition']
            definitions[row['topic_type']] = MessageDefinition(kind, text)
        return [
            Connection(
                row['id'],
                row['name'],
                row['type'],
                definitions.get(row['type'], _NO_DEFINITION),
                row.get('type_description_hash', ''),
                0,
                ConnectionExtRosbag2('cdr', parse_qos(row.get('offered_qos_profiles', ''))),
                self,
            )
            for row in self._rows('SELECT * FROM topics')
            if row['serialization_format'] == 'cdr'
        ]

    def _rows(self, query: str) -> list[dict[str, Any]]:
        """Return all of a table by the names of its columns; none if it is not there."""
        table = query.split()[-1]
        if not self._database.execute(_IS_THERE, (table,)).fetchone():
            return []
        found = self._database.execute(query)
        columns = [column[0] for column in found.description]
        return [dict(zip(columns, row)) for row in found]


def is_short(file: Path) -> bool:
    """Tell whether a database has fewer pages than it says."""
    with file.open('rb') as stream:
        head = stream.read(_HEADER.size)
    if len(head) < _HEADER.size:
        return True
    page_size, counter, pages, valid_for = _HEADER.unpack(head)
    return bool(counter == valid_for and file.stat().st_size < pages * page_size)


def journal_of(file: Path) -> str:
    """Return the name of a journal that holds what a killed recorder wrote last; else ''."""
    names = [f'{file.name}{ending}' for ending in _JOURNALS]
    return next((n for n in names if _size(file.with_name(n)) and file.suffix == '.db3'), '')


def merged(file: Path, folder: Path) -> Path:
    """
    Copy a database with its journal into a folder, and merge both there.

    Raises
    ------
    BagError
        If SQLite cannot.

    """
    copy = folder / file.name
    shutil.copy(file, copy)
    for ending in _JOURNALS:
        journal = file.with_name(f'{file.name}{ending}')
        if journal.exists():
            shutil.copy(journal, folder)
    try:
        with closing(sqlite3.connect(copy)) as database:
            database.execute('PRAGMA wal_checkpoint(TRUNCATE)')
            database.execute('PRAGMA journal_mode = DELETE')
    except sqlite3.DatabaseError as error:
        raise BagError(f'{file} and its journal cannot be merged: {error}') from error
    return copy


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0
