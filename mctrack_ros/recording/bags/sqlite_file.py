"""SQLite files as rosbag2 writes them, schema version 4."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path

from rosbags.interfaces import Qos
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer

from mctrack_ros.recording.bags.definitions import NO_HASH, TypeDefinition
from mctrack_ros.recording.bags.qos import stated


class SqliteFile:
    """
    One file; what is not flushed may be lost. It holds no attachments.

    Parameters
    ----------
    path : Path
        The file; nothing may be there yet.

    Attributes
    ----------
    path, counts, begin_ns, end_ns
        As of `McapFile`.

    Raises
    ------
    OSError
        If SQLite cannot write, as the other methods do.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.counts: dict[str, int] = {}
        self.begin_ns, self.end_ns = 2**63 - 1, 0
        self._topics: dict[str, int] = {}
        self._kinds: set[str] = set()
        path.open('xb').close()
        self._database = sqlite3.connect(path)
        self._do(self._database.executescript, Sqlite3Writer.SQLITE_SCHEMA)

    @property
    def size(self) -> int:
        """Bytes written, up to the last flush."""
        return self.path.stat().st_size

    def add(
        self, topic: str, kind: str, definition: TypeDefinition, offered: Sequence[Qos]
    ) -> None:
        """Make a topic known."""
        type_hash = definition.type_hash or NO_HASH
        if kind not in self._kinds:
            self._kinds.add(kind)
            self._insert(
                'message_definitions', kind, definition.encoding, definition.text, type_hash
            )
        self._insert('topics', topic, kind, 'cdr', stated(offered), type_hash)
        self._topics[topic], self.counts[topic] = len(self._topics) + 1, 0

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        """Append a message of a known topic."""
        self._insert('messages', self._topics[topic], time_ns, data)
        self.counts[topic] += 1
        self.begin_ns, self.end_ns = min(self.begin_ns, time_ns), max(self.end_ns, time_ns)

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Do nothing: there is no place for attachments."""

    def flush(self) -> None:
        """Hand all to the system."""
        self._do(self._database.commit)

    def close(self, metadata: str) -> None:
        """Finish the file, with the metadata of its bag."""
        try:
            self._insert('metadata', 9, metadata)
            self._do(self._database.commit)
        finally:
            self._database.close()

    def _insert(self, table: str, *values: object) -> None:
        places = ', '.join('?' * len(values))
        query = f'INSERT INTO {table} VALUES (NULL, {places})'  # noqa: S608  names are its own
        self._do(self._database.execute, query, values)

    def _do(self, call: object, *arguments: object) -> None:
        """Call SQLite; what fails is an error of the system."""
        assert callable(call)
        try:
            call(*arguments)
        except sqlite3.OperationalError as error:
            raise OSError(f'{self.path}: {error}') from error
