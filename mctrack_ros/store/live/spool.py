"""Messages on disk until they are in the database: a file of SQLite."""

from __future__ import annotations

import sqlite3
import threading
import uuid
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import lz4.frame

from mctrack_ros.recording.closing import Closing
from mctrack_ros.store.errors import StoreError

LEAST_BYTES = 4 << 20
"""A smaller limit counts as this."""
_MOST_UNSAVED = 64 << 20
"""Bytes that wait in memory while the disk is full."""
_MOST_READ = 500
"""Records that are read at once."""
_DROPPED_PARTS = 64
"""Where the limit is reached, the oldest of so many parts is dropped at once."""
_OPEN = (
    'PRAGMA auto_vacuum = FULL',
    'PRAGMA locking_mode = EXCLUSIVE',
    'PRAGMA journal_mode = WAL',
    'PRAGMA secure_delete = ON',
    'CREATE TABLE IF NOT EXISTS records'
    ' (number INTEGER PRIMARY KEY, topic TEXT, log_ns INTEGER, data BLOB)',
    'CREATE TABLE IF NOT EXISTS spool (source TEXT, freed INTEGER)',
)


@dataclass(frozen=True, slots=True)
class Record:
    """
    A message as it came.

    Attributes
    ----------
    number : int
        Counts the messages of a spool, from 1 on.
    topic : str
        Its topic.
    log_ns : int
        When it came, ns.
    data : bytes
        As it was serialised.

    """

    number: int
    topic: str
    log_ns: int
    data: bytes


class Spool(Closing):
    """
    Keep messages until they are in the database.

    One thread puts messages in, one saves them, and one reads them and frees what it has written.
    A record that was saved outlives the process; one that was synchronised, the machine.

    Parameters
    ----------
    folder : Path
        Its folder, made unless it is there; one process at a time has it.
    limit : int
        Bytes on disk; of more, the oldest are dropped.
    latched : str
        Topic whose last message counts for all that follow: it is kept, and read first.

    Attributes
    ----------
    source : str
        Name of the spool, for the database.
    dropped : int
        Records that were dropped before they were freed.
    failure : str
        Why the disk takes nothing; empty: it does.

    Raises
    ------
    StoreError
        If the folder cannot be used, another process has it, or its file is damaged.

    """

    def __init__(self, folder: Path, limit: int, latched: str) -> None:
        self._path, self._limit = folder / 'spool.db', max(limit, LEAST_BYTES)
        self._latched = latched
        self._memory = threading.Lock()
        self._disk = threading.RLock()
        self._unsaved: deque[Record] = deque()
        self._unsaved_bytes = 0
        self.dropped, self.failure = 0, ''
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file: sqlite3.Connection | None = sqlite3.connect(
                self._path, timeout=0.0, isolation_level=None, check_same_thread=False
            )
            for statement in _OPEN:
                self._file.execute(statement)
            self.source, self._freed = self._source()
        except (OSError, sqlite3.Error) as error:
            raise StoreError(_reason(self._path, error)) from error
        last = self._file.execute('SELECT max(number) FROM records').fetchone()[0] or 0
        self._next = max(last, self._freed) + 1
        self.size = self._used()
        self.rewind(self._freed)

    @property
    def waiting(self) -> int:
        """Records that are not freed."""
        with self._memory:
            return self._next - 1 - self._freed

    def put(self, topic: str, log_ns: int, data: bytes) -> None:
        """Take a message."""
        with self._memory:
            record = Record(self._next, topic, log_ns, data)
            self._next += 1
            self._unsaved.append(record)
            self._unsaved_bytes += len(data)
            while self._unsaved_bytes > _MOST_UNSAVED:
                self.dropped += self._take_unsaved().number > self._freed

    def save(self) -> None:
        """Write what has come into the file; if the disk refuses, it waits in memory."""
        with self._memory:
            records = list(self._unsaved)
        if not records:
            return
        packed = [(r.number, r.topic, r.log_ns, lz4.frame.compress(r.data)) for r in records]
        try:
            with self._changing() as file:
                file.executemany('INSERT INTO records VALUES (?, ?, ?, ?)', packed)
                dropped = self._drop_oldest(file)
        except sqlite3.Error as error:
            self.failure = _reason(self._path, error)
            return
        self.failure = ''
        with self._memory:
            self._forget_unsaved(records[-1].number)
            self.dropped += max(dropped - self._freed, 0)
            self._freed = max(self._freed, dropped)

    def synchronise(self) -> None:
        """Let what is saved outlive the machine, and nothing that is freed stay."""
        try:
            with self._disk:
                if self._file is not None:
                    self._file.execute('PRAGMA wal_checkpoint(TRUNCATE)')
        except sqlite3.Error as error:
            self.failure = _reason(self._path, error)

    def rewind(self, number: int) -> None:
        """Read what comes after a record again; before it, the last latched one."""
        self._read, self._is_rewound = number, True

    def read(self) -> list[Record]:
        """
        Return the next records, some hundreds; none: all are read.

        Raises
        ------
        StoreError
            If the file is damaged.

        """
        with self._disk:
            if self._file is None:
                return []
            try:
                rows = self._file.execute(
                    'SELECT * FROM records WHERE number > ? ORDER BY number LIMIT ?',
                    (self._read, _MOST_READ),
                ).fetchall()
                if self._is_rewound:
                    rows = (
                        self._file.execute(
                            'SELECT * FROM records WHERE number <= ? AND topic = ?'
                            ' ORDER BY number DESC LIMIT 1',
                            (self._read, self._latched),
                        ).fetchall()
                        + rows
                    )
            except sqlite3.Error as error:
                raise StoreError(_reason(self._path, error)) from error
        self._is_rewound = False
        found = [
            Record(number, topic, log_ns, lz4.frame.decompress(data))
            for number, topic, log_ns, data in rows
        ]
        if self.failure and len(rows) < _MOST_READ:
            with self._memory:
                last = max([self._read, *(record.number for record in found)])
                found += [record for record in self._unsaved if record.number > last]
        self._read = max([self._read, *(record.number for record in found)])
        return found

    def free(self, number: int) -> None:
        """Forget records until one: they are in the database."""
        with self._memory:
            self._freed = max(self._freed, number)
            if self.failure:
                self._forget_unsaved(number)
        try:
            with self._changing() as file:
                self._delete(file, number)
        except sqlite3.Error as error:
            self.failure = _reason(self._path, error)

    def close(self) -> None:
        """Save and synchronise what has come; leave nothing that is freed."""
        self.save()
        self.free(self._freed)
        self.synchronise()
        with self._disk:
            if self._file is not None:
                self._file.close()
                self._file = None

    def _source(self) -> tuple[str, int]:
        """Return the name of the file, and until which record it is freed; a new one gets one."""
        assert self._file is not None
        found = self._file.execute('SELECT source, freed FROM spool').fetchone()
        if found is None:
            found = uuid.uuid4().hex, 0
            self._file.execute('INSERT INTO spool VALUES (?, ?)', found)
        return str(found[0]), int(found[1])

    @contextmanager
    def _changing(self) -> Iterator[sqlite3.Connection]:
        """Change the file as a whole, or not at all."""
        with self._disk:
            if self._file is None:
                raise sqlite3.ProgrammingError('it is closed')
            with self._file:
                self._file.execute('BEGIN IMMEDIATE')
                yield self._file
            self.size = self._used()

    def _drop_oldest(self, file: sqlite3.Connection) -> int:
        """Keep the limit; return the last record that was dropped, 0: none."""
        last = 0
        while self._used() > self._limit:
            first, count = file.execute(
                'SELECT min(number), count(*) FROM records WHERE number > ?', (last,)
            ).fetchone()
            if count <= 1:
                break
            last = first + count // _DROPPED_PARTS
            self._delete(file, last)
        return last

    def _delete(self, file: sqlite3.Connection, number: int) -> None:
        """Delete records until one, but for the last latched one."""
        file.execute(
            'DELETE FROM records WHERE number <= ?1 AND number IS NOT'
            ' (SELECT max(number) FROM records WHERE number <= ?1 AND topic = ?2)',
            (number, self._latched),
        )
        file.execute('UPDATE spool SET freed = max(freed, ?)', (number,))

    def _used(self) -> int:
        """Return bytes of the file that hold something; the rest goes at the end of a change."""
        assert self._file is not None
        pages, free, size = (
            int(self._file.execute(f'PRAGMA {name}').fetchone()[0])
            for name in ('page_count', 'freelist_count', 'page_size')
        )
        return (pages - free) * size

    def _forget_unsaved(self, number: int) -> None:
        while self._unsaved and self._unsaved[0].number <= number:
            self._take_unsaved()

    def _take_unsaved(self) -> Record:
        oldest = self._unsaved.popleft()
        self._unsaved_bytes -= len(oldest.data)
        return oldest


def _reason(path: Path, error: Exception) -> str:
    """Return why a file cannot be used, and what to do."""
    if isinstance(error, sqlite3.OperationalError) and 'locked' in str(error):
        return (
            f'the spool {path.parent} is in use by another process: end that, or name another '
            'folder'
        )
    if isinstance(error, sqlite3.DatabaseError) and not isinstance(
        error, sqlite3.OperationalError
    ):
        return f'the spool {path} is damaged: move it away ({error})'
    return f'the spool {path.parent} cannot be used: {error}'
