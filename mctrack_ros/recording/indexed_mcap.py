"""MCAP bags of which only the messages wanted are read, where rosbags reads all."""

from __future__ import annotations

import struct
from collections.abc import Collection, Generator, Iterator, Mapping
from typing import Any

from rosbags.interfaces import Connection
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.reader import DirectoryReader, Reader
from rosbags.rosbag2.storage_mcap import ChunkInfo, McapReader, read_exact

_CHUNK = struct.Struct('<BQQQQII')  # opcode, length, times, size, CRC, bytes of the compression
_INDEX = struct.Struct('<BQHI')  # opcode, length, channel, bytes of the entries
_ENTRY = struct.Struct('<QQ')  # log time, place behind the chunk's head
_MESSAGE = struct.Struct('<BQHIQQ')  # opcode, length, channel, sequence, log and publish time
_OF_THE_HEAD = 9  # bytes of opcode and length
_INDEX_OPCODE, _MESSAGE_OPCODE = 0x07, 0x05


class IndexedMcap(McapReader):
    """
    One file, read by its message index (MCAP specification, "Message Index").

    The pictures of all cameras lie in the same chunks, and each camera's process wants one topic.
    Chunks that are compressed, or have a checksum to be tested, rosbags reads whole.
    """

    def messages(
        self,
        connections: Collection[Connection],
        start: int | None = None,
        stop: int | None = None,
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield connection, log time (ns) and data in the same order as rosbags."""
        if not self.chunks or not all(map(self._is_plain, self.chunks)):
            yield from super().messages(connections, start, stop)
            return
        by_id = {connection.id: connection for connection in connections}
        for time_ns, place, channel in sorted(self._entries(by_id)):
            if (start is None or start <= time_ns) and (stop is None or time_ns < stop):
                yield by_id[channel], time_ns, self._message(place, channel)

    def _is_plain(self, chunk: ChunkInfo) -> bool:
        """Tell whether a chunk is neither compressed nor has a checksum."""
        checksum = self._unpacked(_CHUNK, chunk.chunk_start_offset)[5]
        return not chunk.compression and checksum == 0

    def _entries(self, channels: Collection[int]) -> Iterator[tuple[int, int, int]]:
        """Yield log time, place in the file and channel of every message of some channels."""
        assert self.bio
        for chunk in self.chunks:
            first = chunk.chunk_start_offset + _CHUNK.size + 8
            for channel in chunk.message_index_offsets.keys() & channels:
                place = chunk.message_index_offsets[channel]
                opcode, _, found, size = self._unpacked(_INDEX, place)
                if (opcode, found) != (_INDEX_OPCODE, channel) or size % _ENTRY.size:
                    raise ReaderError(f'the message index at {place} is damaged')
                for time_ns, offset in _ENTRY.iter_unpack(read_exact(self.bio, size)):
                    yield time_ns, first + offset, channel

    def _message(self, place: int, channel: int) -> bytes:
        """Return the data of the message at a place."""
        assert self.bio
        opcode, length, found, *_ = self._unpacked(_MESSAGE, place)
        if (opcode, found) != (_MESSAGE_OPCODE, channel):
            raise ReaderError(f'no message of channel {channel} lies at {place}')
        return read_exact(self.bio, length - _MESSAGE.size + _OF_THE_HEAD)

    def _unpacked(self, record: struct.Struct, place: int) -> tuple[int, ...]:
        """Return the first values of the record at a place, after which the file then is."""
        assert self.bio
        self.bio.seek(place)
        return record.unpack(read_exact(self.bio, record.size))


class _IndexedDirectory(DirectoryReader):
    STORAGE_PLUGINS: Mapping[str, type[Any]] = {
        **DirectoryReader.STORAGE_PLUGINS,
        'mcap': IndexedMcap,
    }


class IndexedReader(Reader):
    """Rosbags' reader, with `IndexedMcap` for MCAP files."""

    STORAGE_PLUGINS: Mapping[str, type[Any]] = {**Reader.STORAGE_PLUGINS, 'dir': _IndexedDirectory}
