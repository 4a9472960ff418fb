"""SQLite bags that break off: read row by row, without their indices."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from array import array
from collections.abc import Collection, Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.rosbag2.metadata import parse_qos

from mctrack_ros.recording.errors import BagError

_HEADER = struct.Struct('>16xH6xII60xI')
"""Page size (65536 is written as 1), counter of changes, pages, counter when that was true."""
_JOURNALS = ('-wal', '-journal')
_FORMATS = {'ros2msg': MessageDefinitionFormat.MSG, 'ros2idl': MessageDefinitionFormat.IDL}
_NO_DEFINITION = MessageDefinition(MessageDefinitionFormat.NONE, '')


class SqliteScan:
    """
    All messages of a file that can be read; the interface is that of `McapScan`.

    Parameters
    ----------
    path : Path
        The file.

    Attributes
    ----------
    connections : list of Connection
        Its topics.
    is_whole : bool
        Whether all rows could be read.

    Raises
    ------
    BagError
        If the list of topics cannot be read.

    """

    def __init__(self, path: Path) -> None:
        self._database = sqlite3.connect(f'{path.resolve().as_uri()}?immutable=1', uri=True)
        self._database.execute('PRAGMA writable_schema = ON')  # else a cut file is not opened
        try:
            topics = self._topics()
        except sqlite3.DatabaseError as error:
            self._database.close()
            raise BagError(f'its topics cannot be read: {error}') from error
        found = array('q')
        self.is_whole = False
        with suppress(sqlite3.DatabaseError):  # it breaks off there
            rows = self._database.execute('SELECT id, topic_id, timestamp, data FROM messages')
            for number, topic, time_ns, _ in rows:
                found.extend((time_ns, topic, number))
            self.is_whole = True
        index = np.frombuffer(found, np.int64).reshape(-1, 3)
        self._index = index[np.argsort(index[:, 0], kind='stable')]
        self.connections = [
            topic._replace(msgcount=int(np.count_nonzero(index[:, 1] == topic.id)))
            for topic in topics
        ]

    @property
    def message_count(self) -> int:
        """How many messages were found."""
        return len(self._index)

    @property
    def start_time(self) -> int:
        """Log time of the first message, ns."""
        return int(self._index[0, 0])

    @property
    def end_time(self) -> int:
        """Just after the log time of the last message, ns."""
        return int(self._index[-1, 0]) + 1

    def messages(
        self,
        connections: Collection[Connection] = (),
        start: int | None = None,
        stop: int | None = None,
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, log time (ns) and data, from a start until before a stop."""
        wanted = {each.id: each for each in connections or self.connections}
        times = self._index[:, 0]
        first = 0 if start is None else np.searchsorted(times, start)
        last = len(times) if stop is None else np.searchsorted(times, stop)
        for time_ns, topic, number in self._index[first:last].tolist():
            if topic in wanted:
                query = self._database.execute('SELECT data FROM messages WHERE id = ?', (number,))
                yield wanted[topic], time_ns, query.fetchone()[0]

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def _topics(self) -> list[Connection]:
        definitions: dict[str, MessageDefinition] = {}
        for row in self._rows('message_definitions'):
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
            for row in self._rows('topics')
            if row['serialization_format'] == 'cdr'
        ]

    def _rows(self, table: str) -> list[dict[str, Any]]:
        """Return the rows of a table by the names of its columns; none if it is not there."""
        columns = [row[1] for row in self._database.execute(f'PRAGMA table_info({table})')]
        if not columns:
            return []
        rows = self._database.execute(f'SELECT {", ".join(columns)} FROM {table}')
        return [dict(zip(columns, row)) for row in rows]


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
