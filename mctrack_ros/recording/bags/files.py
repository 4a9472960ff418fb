"""The files of a bag: a folder with or without its metadata, or one file."""

from __future__ import annotations

import re
import warnings
from collections.abc import Collection, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol

from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from mctrack_ros.recording.bags.mcap_scan import MAGIC, McapScan
from mctrack_ros.recording.bags.scan import Scan
from mctrack_ros.recording.bags.sqlite_scan import SqliteScan, is_short, journal_of
from mctrack_ros.recording.errors import BagError, CutBagWarning

_SQLITE_MAGIC = b'SQLite format 3\0'
_ZSTD_MAGIC = bytes.fromhex('28b52ffd')
STORAGES = ('.mcap', '.db3')
"""Endings of the files of bags."""


class Storage(Protocol):
    """What the messages of a file, or of several, are read from."""

    @property
    def connections(self) -> list[Connection]:
        """The topics."""
        ...

    @property
    def message_count(self) -> int:
        """How many messages there are."""
        ...

    @property
    def start_time(self) -> int:
        """Log time of the first, ns."""
        ...

    @property
    def end_time(self) -> int:
        """Just after the log time of the last, ns."""
        ...

    def messages(
        self,
        connections: Collection[Connection] = (),
        start: int | None = None,
        stop: int | None = None,
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, log time (ns) and data, from a start until before a stop."""
        ...

    def close(self) -> None:
        """Close the files."""
        ...


def open_bag(path: Path, *, scanned: bool = False) -> list[Storage]:
    """
    Open a bag's files, in the order in which they were recorded.

    Parameters
    ----------
    path : Path
        The bag.
    scanned : bool
        Whether they are read from end to end at once, past what is damaged.

    Warns
    -----
    CutBagWarning
        If one breaks off or is damaged, or one that the bag names is not there.

    Raises
    ------
    BagError
        If there is no bag, or nothing of it can be read.

    """
    if not path.exists():
        raise BagError(f'{path} does not exist')
    files = _files_in(path) if path.is_dir() else [path]
    for file in files:
        if journal_of(file):
            raise BagError(
                f'{file}: its recorder was killed, and what it wrote last is in '
                f'{journal_of(file)}: merge both by `mctrack bag repair {path} NEW_BAG`'
            )
    reason = ''
    if (path / 'metadata.yaml').exists() and not scanned:
        reader = Reader(path)
        try:
            reader.open()
        except Exception as error:
            reason = one_line(error)
        else:
            assert isinstance(reader.storage, DirectoryReader)
            reason = _contradiction(reader.storage)
            if not reason and all(map(_is_sound, reader.storage.storages)):
                return [reader]
            reader.close()
    if not files:
        raise BagError(f'{path} is no bag: {reason or "it holds no .mcap and no .db3 file"}')
    return _open_files(files, reason, scanned)


def is_bag(path: str | Path) -> bool:
    """Tell whether something is to be read as a bag: a folder, or a file of the name of one."""
    return Path(path).is_dir() or (Path(path).suffix in STORAGES and Path(path).is_file())


def one_line(error: Exception) -> str:
    """Return what rosbags says of a damaged bag."""
    return ' '.join((str(error) or type(error).__name__).split()).rstrip('.')


def _files_in(folder: Path) -> list[Path]:
    """Return the storage files of a folder in the order of their numbers."""
    files = [file for file in folder.iterdir() if file.suffix in STORAGES]
    return sorted(files, key=lambda f: [int(n) for n in re.findall('[0-9]+', f.stem)[-1:]])


def _contradiction(bag: DirectoryReader) -> str:
    """Return in what metadata and files of an open folder differ, which rosbags passes over."""
    there = [(c.topic, c.msgtype, c.ext) for storage in bag.storages for c in storage.connections]
    named = [c for c in bag.connections if c.msgcount]
    lost = [c.topic for c in named if (c.topic, c.msgtype, c.ext) not in there]
    return f'metadata.yaml describes {lost[0]} in another way than the files' if lost else ''


def _is_sound(storage: object) -> bool:
    """Tell whether rosbags reads all of an open file, in the order of its times."""
    if isinstance(storage, Sqlite3Reader):
        return not is_short(Path(str(storage.path)))
    if isinstance(storage, McapReader):
        return bool(storage.chunks) and all(chunk.channel_count for chunk in storage.chunks)
    return True


def _open_files(files: list[Path], reason: str, scanned: bool) -> list[Storage]:
    """Open the files that can be read, and warn of all that is missing."""
    opened: list[Storage] = []
    unread: list[str] = []
    for file in files:
        try:
            storage, is_whole = _open_file(file, scanned)
        except BagError as error:
            unread.append(str(error))
            continue
        opened.append(storage)
        if isinstance(storage, Scan) and storage.losses:
            unread.append(f'{file} is damaged: {_what_is_lost(storage)}; the rest is read')
        if not is_whole:
            last_ns = storage.end_time - 1
            until = datetime.fromtimestamp(last_ns * 1e-9, UTC).isoformat(' ', 'milliseconds')
            seconds = (last_ns - opened[0].start_time) * 1e-9
            unread.append(
                f'{file} breaks off: it is read until {until}, {seconds:.3f} s after its start '
                '(`mctrack bag repair` makes a finished bag of it)'
            )
    if not opened:
        raise BagError(unread[0])
    if reason and not unread:
        unread.append(f'{files[0].parent}: {reason}: it is read by its files alone')
    for text in unread:
        warnings.warn(text, CutBagWarning, stacklevel=2)
    return opened


def _what_is_lost(scan: Scan) -> str:
    """Say how many messages are lost, and when they were logged."""
    counts = [each.messages for each in scan.losses]
    number = f'{sum(counts)} messages' if min(counts) > 0 else 'messages'
    spans = [
        ' to '.join(f'{max(ns - scan.start_time, 0) * 1e-9:.3f}' for ns in each[:2])
        for each in scan.losses
    ]
    return f'{number} are lost, {", ".join(spans)} s after its start'


def _open_file(file: Path, scanned: bool) -> tuple[Storage, bool]:
    """Open one file; return whether it is whole."""
    with file.open('rb') as stream:
        head = stream.read(len(_SQLITE_MAGIC))
    kind = McapScan if head.startswith(MAGIC) else SqliteScan if head == _SQLITE_MAGIC else None
    if kind is None:
        raise BagError(f'{file} {_what_else(head)}')
    if file.suffix in STORAGES and not scanned:
        reader = Reader(file)
        with suppress(Exception):  # cut off, or of another profile: see below
            reader.open()
            if _is_sound(reader.storage):
                return reader, True
            reader.close()
    try:
        scan = kind(file)
    except BagError as error:
        raise BagError(f'{file}: {error}') from error
    if scan.message_count == 0:
        scan.close()
        raise BagError(
            f'{file} holds no messages of ROS 2'
            if scan.is_whole
            else f'{file} breaks off before its first message'
        )
    return scan, scan.is_whole


def _what_else(head: bytes) -> str:
    """Return what a file is that is neither MCAP nor SQLite."""
    if not head:
        return 'is empty: nothing was recorded, or the disk was full'
    if MAGIC.startswith(head):
        return 'breaks off before its first message'
    if head.startswith(b'#ROSBAG'):
        return 'is a bag of ROS 1: convert it by `rosbags-convert`'
    if head.startswith(_ZSTD_MAGIC):
        return "is packed as a whole: unpack it by `zstd -d`, or name the bag's folder"
    return 'is no bag: expected an .mcap or .db3 file, or a folder with some'
