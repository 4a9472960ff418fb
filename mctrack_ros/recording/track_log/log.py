"""
The track log of a bag: its hash, and checksums of all messages, field by field.

Canonical form of a cloud: its stamp, and for each field that the message describes, in that
order, the values of all points one after another. Padding, and what differs between two
serialisations of the same message, is left out. Other messages count as they are stored.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import CodecError, fields_of_cloud, stamp_ns_of
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.recording.track_log.provenance import provenance

SUMMARY = 'mctrack/track_log.json'
"""Attachment: hash of each topic of tracks, versions, processor."""
CHECKSUMS = 'mctrack/checksums'
"""Attachments of that name with a number: checksums of messages."""

RECORDING = 'mctrack/recording.json'
"""Attachment: of each topic, how many messages came to the recorder and how many did not."""

CLOUD = 'sensor_msgs/msg/PointCloud2'
TRACKS = '/tracks'
EMPTY = bytes(32)
"""Hash of no ticks."""
_FORMAT = 1
_BLOCK = 20_000
WHOLE = 'message'
"""The only field of a message that is no cloud."""

Fields = Mapping[str, bytes]


def cloud_fields(message: Any) -> Fields:
    """
    Return the canonical bytes of a cloud, by field.

    Raises
    ------
    CodecError
        If the message's sizes or fields are wrong.

    """
    return {name: values.tobytes() for name, values in fields_of_cloud(message).items()}


def chained(before: bytes, stamp_ns: int, fields: Fields) -> bytes:
    """
    Return the SHA-256 of a log that goes on with a message.

    Parameters
    ----------
    before : bytes
        That of the log up to there; `EMPTY` at its beginning.
    stamp_ns : int
        Stamp of the message, ns.
    fields : mapping of str to bytes
        As `cloud_fields` returns them.

    """
    digest = hashlib.sha256(before + struct.pack('<q', stamp_ns))
    for name, data in fields.items():
        digest.update(f'{name} {len(data)} '.encode() + data)
    return digest.digest()


@dataclass(frozen=True, eq=False, slots=True)
class Checksums:
    """
    CRC-32 of the messages of one topic: one changed bit never goes unnoticed.

    Attributes
    ----------
    fields : tuple of str
        What each column is of.
    time_ns, stamp_ns : (n,) int64 arrays
        Log times; stamps of clouds, else the same, ns.
    values : (n, fields) uint32 array

    """

    fields: tuple[str, ...]
    time_ns: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    values: NDArray[np.uint32]


@dataclass(frozen=True, slots=True)
class Canonical:
    """
    A message in canonical form.

    Attributes
    ----------
    stamp_ns : int
        Stamp of a cloud; of another message its log time, ns.
    fields : mapping of str to bytes
        Of a cloud its fields; of another message all as one, ``message``.

    """

    stamp_ns: int
    fields: Fields

    @classmethod
    def of(cls, kind: str, data: bytes, time_ns: int) -> Canonical:
        """Return that of a serialised message; a cloud that cannot be read counts as it is."""
        if kind == CLOUD:
            try:
                message = TYPES.deserialize_cdr(memoryview(data), kind)
                return cls(stamp_ns_of(message), cloud_fields(message))
            except (CodecError, ValueError, struct.error, IndexError):
                pass
        return cls(time_ns, {WHOLE: data})

    def checksums(self) -> list[int]:
        """Return the CRC-32 of each field."""
        return [zlib.crc32(data) for data in self.fields.values()]


class MessageLog:
    """
    Takes down the messages of a bag as they are written.

    Parameters
    ----------
    made_by : mapping of str to str, optional
        Versions and processor that the messages come of; unless given, those of here.

    Attributes
    ----------
    hashes : dict of str to (int, bytes)
        Of each topic of tracks: number of messages and SHA-256.

    """

    def __init__(self, made_by: Mapping[str, str] | None = None) -> None:
        self._made_by = provenance() if made_by is None else made_by
        self.hashes: dict[str, tuple[int, bytes]] = {}
        self._rows: dict[tuple[str, tuple[str, ...]], array[int]] = {}
        self._count = 0

    @property
    def is_full(self) -> bool:
        """Whether there are enough checksums to be put away."""
        return self._count >= _BLOCK

    def add(self, topic: str, kind: str, data: bytes, time_ns: int) -> None:
        """Take down a message."""
        message = Canonical.of(kind, data, time_ns)
        if kind == CLOUD and is_track_log(topic) and WHOLE not in message.fields:
            count, before = self.hashes.get(topic, (0, EMPTY))
            after = chained(before, message.stamp_ns, message.fields)
            self.hashes[topic] = count + 1, after
        rows = self._rows.setdefault((topic, tuple(message.fields)), array('q'))
        rows.extend((time_ns, message.stamp_ns, *message.checksums()))
        self._count += 1

    def take_checksums(self) -> dict[str, list[Checksums]]:
        """Return the checksums since the last call, by topic; of each, one for its fields."""
        taken: dict[str, list[Checksums]] = {}
        for (topic, fields), rows in self._rows.items():
            table = np.frombuffer(rows, np.int64).reshape(-1, 2 + len(fields))
            values = table[:, 2:].astype(np.uint32)
            sums = Checksums(fields, table[:, 0].copy(), table[:, 1].copy(), values)
            taken.setdefault(topic, []).append(sums)
        self._rows, self._count = {}, 0
        return taken

    def summary(self) -> bytes:
        """Return hashes, versions and processor as JSON."""
        logs = {
            topic: {'messages': count, 'sha256': digest.hex()}
            for topic, (count, digest) in sorted(self.hashes.items())
        }
        values = {'format': _FORMAT, 'logs': logs, 'made_by': dict(self._made_by)}
        return json.dumps(values, sort_keys=True, indent=1).encode()


def is_track_log(topic: str) -> bool:
    """Tell whether a topic holds a fusion node's tracks; truth is none."""
    return topic.endswith(TRACKS) and not topic.endswith(f'/truth{TRACKS}')


def packed(taken: Mapping[str, list[Checksums]]) -> bytes:
    """Return checksums as the bytes of an attachment: an npz file."""
    arrays: dict[str, Any] = {}
    heads: list[list[Any]] = []
    for topic, parts in taken.items():
        for part in parts:
            number = len(heads)
            heads.append([topic, list(part.fields)])
            arrays |= {f'{number}.{name}': getattr(part, name) for name in _ARRAYS}
    arrays['heads'] = np.frombuffer(json.dumps(heads).encode(), np.uint8)
    out = BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


_ARRAYS = ('time_ns', 'stamp_ns', 'values')


@dataclass(frozen=True, eq=False, slots=True)
class StoredLog:
    """
    What a bag says of itself.

    Attributes
    ----------
    hashes : dict of str to (int, bytes)
        Of each topic of tracks: number of messages and SHA-256.
    made_by : mapping
        Versions and processor; empty: not known.
    checksums : dict of str to list of Checksums
        By topic, in the order of recording.

    """

    hashes: Mapping[str, tuple[int, bytes]]
    made_by: Mapping[str, str]
    checksums: Mapping[str, list[Checksums]]

    @classmethod
    def of(cls, attachments: Mapping[str, bytes]) -> StoredLog:
        """
        Read it from the attachments of a bag.

        Raises
        ------
        ValueError
            If they are of a later version of the package, or damaged.

        """
        said = json.loads(attachments.get(SUMMARY, b'{}'))
        if said.get('format', _FORMAT) != _FORMAT:
            raise ValueError(f'{SUMMARY} has the format {said["format"]}, expected {_FORMAT}')
        hashes = {
            topic: (int(each['messages']), bytes.fromhex(each['sha256']))
            for topic, each in said.get('logs', {}).items()
        }
        checksums: dict[str, list[Checksums]] = {}
        for name in sorted(n for n in attachments if n.startswith(f'{CHECKSUMS}/')):
            for topic, part in _unpacked(attachments[name]):
                checksums.setdefault(topic, []).append(part)
        return cls(hashes, said.get('made_by', {}), checksums)

    def changed_field(self, topic: str, time_ns: int, message: Canonical) -> str:
        """Return the first field of a message that is not what was written; empty: all are."""
        fields, sums, changed = tuple(message.fields), message.checksums(), ''
        for part in self.checksums.get(topic, ()):
            first, last = np.searchsorted(part.time_ns, [time_ns, time_ns + 1])
            for row in range(first, last):
                if part.fields != fields:
                    changed = changed or WHOLE
                    continue
                differ = np.flatnonzero(part.values[row] != sums)
                if not len(differ):
                    if part.stamp_ns[row] == message.stamp_ns:
                        return ''
                    changed = 'stamp'
                else:
                    changed = fields[int(differ[0])]
        return changed


def _unpacked(data: bytes) -> list[tuple[str, Checksums]]:
    with np.load(BytesIO(data)) as arrays:
        heads = json.loads(arrays['heads'].tobytes())
        return [
            (topic, Checksums(tuple(fields), *(arrays[f'{number}.{name}'] for name in _ARRAYS)))
            for number, (topic, fields) in enumerate(heads)
        ]
