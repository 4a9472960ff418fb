"""Messages on disk until they are in the database: files that are only appended to."""

from __future__ import annotations

import fcntl
import json
import os
import struct
import threading
import uuid
import zlib
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import lz4.block

from mctrack_ros.recording.closing import Closing
from mctrack_ros.store.errors import StoreError

FILE_BYTES = 1 << 20
"""Of a file of the spool: the oldest is dropped as a whole."""
_MOST_UNSAVED = 64 << 20
"""Bytes that wait in memory while the disk is full."""
_FRAME = struct.Struct('<4sIIQI')
"""Before the records of one write: mark, bytes, checksum, number of the first record, records."""
_MARK = b'mct1'
_RECORD = struct.Struct('<qHI')
"""Before a record: log time, ns, length of its topic and of its data."""


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

    def packed(self) -> bytes:
        """Return it without its number."""
        topic = self.topic.encode()
        return _RECORD.pack(self.log_ns, len(topic), len(self.data)) + topic + self.data


@dataclass(slots=True, eq=False)
class _File:
    """A file of the spool: number of its first record, and how many bytes of it are whole."""

    path: Path
    first: int
    size: int = 0


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
        Topic whose last message counts for all that follow: each file begins with it.

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
        If the folder cannot be used, or another process has it.

    """

    def __init__(self, folder: Path, limit: int, latched: str) -> None:
        self._folder, self._limit, self._latched = folder, max(limit, 4 * FILE_BYTES), latched
        self._lock = threading.Lock()
        self._unsaved: deque[Record] = deque()
        self._unsaved_bytes = 0
        self._last_latched: Record | None = None
        self._out: IO[bytes] | None = None
        self._is_dirty = False
        self._reading: _File | None = None
        self._damaged = 0
        self.dropped, self.failure = 0, ''
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._guard = _locked(folder)
            paths = sorted(folder.glob('*.spool'))
            self.source = _source(folder, is_new=not paths)
            self._files = [_File(path, int(path.stem), path.stat().st_size) for path in paths]
            self._next = self._read_ends()
        except (OSError, ValueError) as error:
            raise StoreError(f'the spool {folder} cannot be used: {error}') from error
        self._freed = self._files[0].first - 1 if self._files else self._next - 1
        self.rewind(self._freed)

    @property
    def size(self) -> int:
        """Bytes on disk."""
        with self._lock:
            return sum(file.size for file in self._files)

    @property
    def waiting(self) -> int:
        """Records that are not freed."""
        with self._lock:
            return self._next - 1 - self._freed

    def put(self, topic: str, log_ns: int, data: bytes) -> None:
        """Take a message."""
        with self._lock:
            record = Record(self._next, topic, log_ns, data)
            self._next += 1
            self._unsaved.append(record)
            self._unsaved_bytes += len(data)
            while self._unsaved_bytes > _MOST_UNSAVED:
                oldest = self._unsaved.popleft()
                self._unsaved_bytes -= len(oldest.data)
                self.dropped += oldest.number > self._freed

    def save(self) -> None:
        """Append what has come to the files; if the disk refuses, it waits in memory."""
        with self._lock:
            records = list(self._unsaved)
        if not records:
            return
        try:
            for part in _runs_of(records):
                self._append(part)
                self._forget_unsaved(part[-1].number)
        except OSError as error:
            self.failure = f'{self._folder}: {error.strerror or error}'
            self._leave_file()
        else:
            self.failure = ''
        self._drop_oldest()

    def synchronise(self) -> None:
        """Let what is saved outlive the machine."""
        if self._is_dirty and self._out is not None:
            self._is_dirty = False
            try:
                os.fsync(self._out.fileno())
            except OSError as error:
                self.failure = f'{self._folder}: {error.strerror or error}'

    def rewind(self, number: int) -> None:
        """Read what comes after a record again; before it, the last latched one."""
        self._reading, self._offset, self._read = None, 0, number

    def read(self) -> list[Record]:
        """Return the next records, some hundreds; none: all are read. Latched ones come again."""
        while not self._guard.closed:
            with self._lock:
                if self._reading not in self._files:
                    self._reading = self._files[0] if self._files else None
                    self._offset = 0
                file, size = self._reading, self._reading.size if self._reading else 0
                at = self._files.index(file) if file else 0
                following = self._files[at + 1] if at + 1 < len(self._files) else None
                unsaved = list(self._unsaved) if self.failure else []
            if file is None:
                found = unsaved
            else:
                found, self._offset = _records(file.path, self._offset, size)
                if following is None:
                    found += unsaved
            wanted = [r for r in found if r.number > self._read or r.topic == self._latched]
            self._read = max([self._read, *(record.number for record in wanted)])
            if following is not None:
                self._count_damaged(following.first - 1)
                self._reading, self._offset = following, 0
            if wanted or following is None:
                return wanted
        return []

    def free(self, number: int) -> None:
        """Forget records until one: they are in the database."""
        with self._lock:
            self._freed = max(self._freed, number)
            while len(self._files) > 1 and self._files[1].first <= self._freed + 1:
                self._remove_first()
            while self.failure and self._unsaved and self._unsaved[0].number <= self._freed:
                self._unsaved_bytes -= len(self._unsaved.popleft().data)

    def close(self) -> None:
        """Save and synchronise what has come; leave nothing that is freed."""
        self.save()
        self.synchronise()
        if self._freed == self._next - 1 and not self.failure:
            try:
                self._begin_file()
                self.free(self._freed)
            except OSError as error:
                self.failure = f'{self._folder}: {error.strerror or error}'
        self._leave_file()
        self._guard.close()

    def _append(self, records: Sequence[Record]) -> None:
        """Write records, whose numbers follow one another, as a frame."""
        if self._out is None or self._files[-1].size >= FILE_BYTES:
            self._begin_file()
        self._write(_frame(records))
        latched = [record for record in records if record.topic == self._latched]
        self._last_latched = latched[-1] if latched else self._last_latched

    def _begin_file(self) -> None:
        """Begin a file, with the last latched message."""
        self._leave_file()
        with self._lock:
            first = self._unsaved[0].number if self._unsaved else self._next
        path = self._folder / f'{first:020d}.spool'
        self._out = path.open('wb', buffering=0)
        with self._lock:
            self._files = [each for each in self._files if each.path != path]
            self._files.append(_File(path, first))
        _synchronise_folder(self._folder)
        if self._last_latched is not None:
            self._write(_frame([self._last_latched]))

    def _write(self, frame: bytes) -> None:
        """Append a frame as a whole, or nothing."""
        assert self._out is not None
        file, rest = self._files[-1], memoryview(frame)
        try:
            while rest:
                rest = rest[self._out.write(rest) :]
        except OSError:
            os.ftruncate(self._out.fileno(), file.size)
            raise
        with self._lock:
            file.size += len(frame)
        self._is_dirty = True

    def _leave_file(self) -> None:
        if self._out is not None:
            self.synchronise()
            self._out.close()
            self._out = None

    def _forget_unsaved(self, number: int) -> None:
        with self._lock:
            while self._unsaved and self._unsaved[0].number <= number:
                self._unsaved_bytes -= len(self._unsaved.popleft().data)

    def _drop_oldest(self) -> None:
        """Keep the limit."""
        with self._lock:
            while sum(file.size for file in self._files) > self._limit and len(self._files) > 1:
                last = self._files[1].first - 1
                self.dropped += max(last - self._freed, 0)
                self._freed = max(self._freed, last)
                self._remove_first()

    def _remove_first(self) -> None:
        self._files.pop(0).path.unlink(missing_ok=True)

    def _count_damaged(self, last: int) -> None:
        """Count what a file should hold until a record, and does not."""
        known = max(self._read, self._freed, self._damaged)
        if last > known:
            self.dropped += last - known
            self._damaged = last

    def _read_ends(self) -> int:
        """Cut off what the last file has of a frame that was not finished; return what follows."""
        following = 1
        for file in self._files[-1:]:
            records, size = _records(file.path, 0, file.size)
            os.truncate(file.path, size)
            file.size = size
            following = max([file.first, *(record.number + 1 for record in records)])
            latched = [record for record in records if record.topic == self._latched]
            self._last_latched = latched[-1] if latched else None
        return following


def _runs_of(records: Sequence[Record]) -> Iterator[Sequence[Record]]:
    """Yield the records in parts of a file's size at most."""
    start = size = 0
    for index, record in enumerate(records):
        if size > FILE_BYTES:
            yield records[start:index]
            start, size = index, 0
        size += len(record.data)
    yield records[start:]


def _frame(records: Sequence[Record]) -> bytes:
    packed: bytes = lz4.block.compress(b''.join(record.packed() for record in records))
    first = records[0].number
    return _FRAME.pack(_MARK, len(packed), zlib.crc32(packed), first, len(records)) + packed


def _records(path: Path, start: int, end: int) -> tuple[list[Record], int]:
    """Return the records of the whole frames of a part of a file, and where these end."""
    try:
        with path.open('rb') as file:
            file.seek(start)
            data = file.read(end - start)
    except FileNotFoundError:  # dropped meanwhile
        return [], start
    at = 0
    found: list[Record] = []
    while at + _FRAME.size <= len(data):
        mark, size, checksum, number, count = _FRAME.unpack_from(data, at)
        packed = data[at + _FRAME.size : at + _FRAME.size + size]
        if mark != _MARK or len(packed) != size or zlib.crc32(packed) != checksum:
            break
        at += _FRAME.size + size
        found += _unpacked(lz4.block.decompress(packed), number, count)
    return found, start + at


def _unpacked(data: bytes, number: int, count: int) -> Iterator[Record]:
    at = 0
    for each in range(number, number + count):
        log_ns, topic_size, size = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        topic = data[at : at + topic_size].decode()
        at += topic_size
        yield Record(each, topic, log_ns, data[at : at + size])
        at += size


def _locked(folder: Path) -> IO[str]:
    """Lock a folder for as long as the returned file is open."""
    guard = (folder / 'lock').open('a', encoding='utf-8')
    try:
        fcntl.flock(guard, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        guard.close()
        raise StoreError(
            f'the spool {folder} is in use by another process: end that, or name another folder'
        ) from error
    return guard


def _source(folder: Path, is_new: bool) -> str:
    """Return the name of a spool; one without files counts from 1 and gets another."""
    path = folder / 'source.json'
    if not is_new:
        try:
            return str(json.loads(path.read_text(encoding='utf-8'))['source'])
        except (OSError, ValueError, LookupError, TypeError) as error:
            raise ValueError(f'{path} holds no name of a spool: delete the folder') from error
    name = uuid.uuid4().hex
    fresh = path.with_suffix('.new')
    fresh.write_text(json.dumps({'source': name}), encoding='utf-8')
    fresh.replace(path)
    return name


def _synchronise_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
