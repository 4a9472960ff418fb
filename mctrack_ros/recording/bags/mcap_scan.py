"""
MCAP files without a usable index: cut off, damaged, or never indexed.

The records are read in the order in which they lie in the file (https://mcap.dev/spec), to its
end or to where it breaks off; of a chunk that breaks off, what can still be unpacked.
"""

from __future__ import annotations

import struct
import sys
import zlib
from array import array
from collections.abc import Callable, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from lz4.frame import LZ4FrameDecompressor
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.rosbag2.metadata import parse_qos

from mctrack_ros.recording.bags.scan import Loss, Scan
from mctrack_ros.recording.errors import BagError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAGIC = b'\x89MCAP0\r\n'
"""What an MCAP file begins and ends with."""

_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _MESSAGE_INDEX = 2, 3, 4, 5, 6, 7
_FORMATS = {
    'ros2msg': MessageDefinitionFormat.MSG,
    'ros2idl': MessageDefinitionFormat.IDL,
    'omgidl': MessageDefinitionFormat.IDL,
}
_UNPACKERS: dict[str, Callable[[], Any]] = {
    'lz4': LZ4FrameDecompressor,
    'zstd': zstd.ZstdDecompressor,
}
_PIECE = 1 << 16
_LARGEST_CHUNK = 1 << 30
"""Unpacked, bytes: one that goes on is taken for damaged there."""
_NO_CHUNK = -1
_INDEX_ENTRY = 16
_CHUNKS_KEPT = 4


class McapScan(Scan):
    """
    All messages of a file that can be read, found without its index; damaged chunks are passed.

    Parameters
    ----------
    path : Path
        The file; it begins with `MAGIC`.

    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._end = path.stat().st_size
        self._schemas: dict[int, tuple[str, MessageDefinition]] = {}
        self._channels: dict[int, Connection] = {}
        self._chunk_sizes: dict[int, int] = {}
        self._unpacked: dict[int, bytes] = {}
        self._found = array('q')
        self._file = path.open('rb')
        try:
            with suppress(struct.error, ValueError, OverflowError):  # damaged: breaks off there
                self._scan()
        except BaseException:
            self._file.close()
            raise
        self._keep(self._found, 5, self._channels.values())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _scan(self) -> None:
        """Find what the file holds, to its footer or to where it breaks off."""
        is_damaged = False
        for code, offset, size in _records(self._file, len(MAGIC), self._end):
            if code == _FOOTER:
                self._file.seek(offset + size)
                self.is_whole = self._file.read(len(MAGIC)) == MAGIC
                return
            if code == _CHUNK:
                self._chunk_sizes[offset] = min(size, self._end - offset)
                data, is_sound = self._chunk(offset)
                inner = BytesIO(data)
                for record in _records(inner, 0, len(data)):
                    self._take(inner, *record, offset, len(data))
                is_damaged = not is_sound
                if is_damaged and offset + size >= self._end:
                    return
                if is_damaged:
                    self._note_loss(offset)
            elif code == _MESSAGE_INDEX and is_damaged:
                self._count_lost(offset)
            else:
                self._take(self._file, code, offset, size, _NO_CHUNK, self._end)

    def _note_loss(self, chunk: int) -> None:
        """Note a damaged chunk; its index, which follows, says how many messages it held."""
        self._file.seek(chunk)
        begin_ns, end_ns = struct.unpack('<QQ', self._file.read(16))
        kept = sum(1 for at in self._found[2::5] if at == chunk)
        self.losses.append(Loss(begin_ns, end_ns, -kept))

    def _count_lost(self, offset: int) -> None:
        """Add the messages that the index of a damaged chunk names to what is lost."""
        self._file.seek(offset)
        (size,) = struct.unpack('<2xI', self._file.read(6))
        loss = self.losses[-1]
        self.losses[-1] = loss._replace(messages=loss.messages + size // _INDEX_ENTRY)

    def _take(
        self, stream: BinaryIO, code: int, offset: int, size: int, chunk: int, end: int
    ) -> None:
        """Note what a record says, unless it breaks off."""
        if offset + size > end:
            return
        stream.seek(offset)
        if code == _MESSAGE:
            channel, log_time = struct.unpack('<H4xQ8x', stream.read(min(size, 22)))
            if channel in self._channels:
                self._found.extend((log_time, channel, chunk, offset + 22, size - 22))
        elif code == _SCHEMA:
            block = _Block(stream.read(size))
            number, name, encoding = block.number('<H'), block.text(), block.text()
            known = _FORMATS.get(encoding, MessageDefinitionFormat.NONE)
            self._schemas[number] = (name, MessageDefinition(known, block.text()))
        elif code == _CHANNEL:
            block = _Block(stream.read(size))
            number, schema = block.number('<H'), block.number('<H')
            topic, encoding = block.text(), block.text()
            if encoding == 'cdr' and schema in self._schemas and number not in self._channels:
                stated = dict(block.pairs())
                offered = parse_qos(stated.get('offered_qos_profiles', ''))
                self._channels[number] = Connection(
                    number,
                    topic,
                    *self._schemas[schema],
                    stated.get('topic_type_hash', ''),
                    0,
                    ConnectionExtRosbag2(encoding, offered),
                    self,
                )

    def _data(self, *place: int) -> bytes:
        chunk, offset, size = place
        if chunk == _NO_CHUNK:
            self._file.seek(offset)
            return self._file.read(size)
        if chunk not in self._unpacked:
            if len(self._unpacked) == _CHUNKS_KEPT:
                del self._unpacked[next(iter(self._unpacked))]
            self._unpacked[chunk] = self._chunk(chunk)[0]
        return self._unpacked[chunk][offset : offset + size]

    def _chunk(self, offset: int) -> tuple[bytes, bool]:
        """Return what a chunk holds, as far as it can be unpacked, and whether that is all."""
        self._file.seek(offset)
        block = _Block(self._file.read(self._chunk_sizes[offset]))
        block.at = 16
        try:
            size, checksum, method = block.number('<Q'), block.number('<I'), block.text()
            packed = block.bytes[block.at + 8 :][: block.number('<Q')]
        except struct.error:
            return b'', False
        data = _unpacked(packed, method)
        if len(data) == size and checksum and zlib.crc32(data) != checksum:
            return b'', False
        return data, len(data) == size


class _Block:
    """The fields of a record, one after another."""

    def __init__(self, data: bytes) -> None:
        self.bytes = data
        self.at = 0

    def number(self, layout: str) -> int:
        (value,) = struct.unpack_from(layout, self.bytes, self.at)
        self.at += struct.calcsize(layout)
        return int(value)

    def text(self) -> str:
        size = self.number('<I')
        self.at += size
        return self.bytes[self.at - size : self.at].decode()

    def pairs(self) -> Iterator[tuple[str, str]]:
        end = self.number('<I') + self.at
        while self.at < end:
            yield self.text(), self.text()


def _records(stream: BinaryIO, offset: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield code, offset and size of each record's content; the last may reach past the end."""
    while offset + 9 <= end:
        stream.seek(offset)
        code, size = struct.unpack('<BQ', stream.read(9))
        if code == 0:
            return
        offset += 9
        yield code, offset, size
        offset += size


def _unpacked(packed: bytes, method: str) -> bytes:
    """
    Return what was packed, as far as it goes.

    Raises
    ------
    BagError
        If it was packed in a way that is not known.

    """
    if not method:
        return packed
    if method not in _UNPACKERS:
        raise BagError(f'chunks are packed by {method!r}, expected lz4 or zstd')
    unpacker, data = _UNPACKERS[method](), bytearray()
    for start in range(0, len(packed), _PIECE):
        if len(data) > _LARGEST_CHUNK:
            break
        try:
            piece = packed[start : start + _PIECE]
            data += unpacker.decompress(piece, _LARGEST_CHUNK + 1 - len(data))
        except (RuntimeError, EOFError, zstd.ZstdError):
            break
    return bytes(data)
