"""MCAP files as rosbag2 writes them: chunks, attachments, and the metadata of their bag."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
from rosbags.interfaces import Qos

from mctrack_ros.recording.bags.definitions import NO_HASH, TypeDefinition
from mctrack_ros.recording.bags.qos import stated


class McapFile:
    """
    One file of the profile ``ros2``; what is not flushed or closed may be lost.

    Parameters
    ----------
    path : Path
        The file; nothing may be there yet.
    is_packed : bool
        Whether chunks are compressed, by zstd.

    Attributes
    ----------
    path : Path
        The file.
    counts : dict of str to int
        Messages by topic.
    begin_ns, end_ns : int
        Log times of the first and the last message, ns.

    """

    def __init__(self, path: Path, *, is_packed: bool) -> None:
        self.path = path
        self.counts: dict[str, int] = {}
        self.begin_ns, self.end_ns = 2**63 - 1, 0
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        packing = CompressionType.ZSTD if is_packed else CompressionType.NONE
        self._stream = path.open('xb')
        self._writer: Any = Writer(self._stream, compression=packing)
        self._writer.start('ros2', 'mctrack_ros')

    @property
    def size(self) -> int:
        """Bytes written; the chunk that is being filled does not count."""
        return self._stream.tell()

    def add(
        self, topic: str, kind: str, definition: TypeDefinition, offered: Sequence[Qos]
    ) -> None:
        """Make a topic known."""
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(
                kind, definition.encoding, definition.text.encode()
            )
        said = {
            'offered_qos_profiles': stated(offered),
            'topic_type_hash': definition.type_hash or NO_HASH,
        }
        channel = self._writer.register_channel(topic, 'cdr', self._schemas[kind], said)
        self._channels[topic], self.counts[topic] = channel, 0

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        """Append a message of a known topic."""
        count = self.counts[topic]
        self._writer.add_message(self._channels[topic], time_ns, data, time_ns, count % 2**32)
        self.counts[topic] = count + 1
        self.begin_ns, self.end_ns = min(self.begin_ns, time_ns), max(self.end_ns, time_ns)

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Append an attachment."""
        self._writer.add_attachment(time_ns, time_ns, name, media_type, data)

    def flush(self) -> None:
        """Finish the chunk that is being filled, and hand all to the system."""
        self._writer.flush()

    def close(self, metadata: str) -> None:
        """Finish the file, with the metadata of its bag."""
        try:
            self._writer.flush()
            self._writer.add_metadata('rosbag2', {'serialized_metadata': metadata})
            self._writer.finish()
        except OSError:
            with suppress(OSError):
                self._stream.close()
            raise
        self._stream.close()
        self._writer = None  # its index of all chunks was for the end of the file
