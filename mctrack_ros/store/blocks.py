"""Rows of `/tracks` as blocks of numbers that compress well, without loss."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import lz4.block
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Tracks

Words = NDArray[np.uint32]

_UPPER, _RIGHT = np.triu_indices(4)
PLACES = (
    ('offset', 1),
    ('position', 3),
    ('covariance', 10),
    ('group', 1),
    ('status', 1),
)
"""Columns of the first blob, with their widths; the offset is that of the stamp, ns."""
REST = (
    ('velocity', 2),
    ('extent', 2),
    ('age', 1),
    ('score', 1),
    ('cameras', 1),
    ('member_count', 1),
    ('class_id', 1),
    ('kit', 1),
    ('rank', 1),
)
"""Columns of the second blob; the rank is the row's place in its message."""


def _slices(columns: Sequence[tuple[str, int]], start: int) -> dict[str, slice]:
    ends = np.cumsum([start, *(width for _, width in columns)]).tolist()
    return {name: slice(*pair) for (name, _), pair in zip(columns, pairwise(ends))}


ID = 0
"""Column of a row's track id; places and the rest follow."""
WHERE = _slices(PLACES, 1) | _slices(REST, 1 + sum(width for _, width in PLACES))
"""Columns of a row by name."""
PLACES_WIDTH = sum(width for _, width in PLACES)
REST_WIDTH = sum(width for _, width in REST)
WIDTH = 1 + PLACES_WIDTH + REST_WIDTH
_OFFSET, _RANK = WHERE['offset'].start, WHERE['rank'].start


def pack(words: NDArray[Any]) -> bytes:
    """
    Return a matrix of unsigned numbers, (n, k), compressed: what comes next is close.

    Differences of the rows, byte by byte of equal weight, by LZ4: zstd saves 1 % and takes 14
    times as long to read.
    """
    differences = words.copy()
    differences[1:] -= words[:-1]
    size = words.dtype.itemsize
    octets = differences.view(np.uint8).reshape(*words.shape, size)
    packed: bytes = lz4.block.compress(
        octets.transpose(1, 2, 0).tobytes(), mode='high_compression'
    )
    return packed


def unpack(blob: bytes, width: int, kind: type[np.unsignedinteger[Any]] = np.uint32) -> Any:
    """Return the matrix, (n, width), of such numbers, that was packed."""
    return unpack_all([blob], width, kind)[0]


def unpack_all(
    blobs: Sequence[bytes], width: int, kind: type[np.unsignedinteger[Any]] = np.uint32
) -> tuple[Any, NDArray[np.intp]]:
    """Return several matrices as one, (n, width), and how many rows are of each."""
    size = np.dtype(kind).itemsize
    parts = [np.frombuffer(lz4.block.decompress(blob), np.uint8) for blob in blobs]
    counts = np.array([len(part) for part in parts], np.intp) // (width * size)
    shaped = [part.reshape(width * size, -1) for part in parts]
    octets = np.concatenate([np.zeros((width * size, 0), np.uint8), *shaped], axis=1)
    by_row = np.ascontiguousarray(octets.reshape(width, size, -1).transpose(2, 0, 1))
    sums = np.zeros((len(by_row) + 1, width), kind)
    np.cumsum(by_row.view(kind)[..., 0], axis=0, dtype=kind, out=sums[1:])
    before = sums[np.cumsum(counts) - counts]
    return sums[1:] - np.repeat(before, counts, axis=0), counts


def words_of(rows: Tracks, began_ns: int) -> Words:
    """Return rows as numbers, (n, WIDTH), their stamps from the beginning of a window on."""
    words = np.zeros((len(rows), WIDTH), np.uint32)
    words[:, ID] = rows.track_id
    words[:, _OFFSET] = rows.stamp_ns - began_ns
    words[:, _RANK] = np.arange(len(rows))
    floats = words.view(np.float32)
    for name, where in WHERE.items():
        if name == 'covariance':
            floats[:, where] = rows.covariance[:, _UPPER, _RIGHT]
        elif name not in {'offset', 'rank'}:
            values = getattr(rows, name)
            into = floats if values.dtype.kind == 'f' else words
            into[:, where] = values.reshape(len(rows), where.stop - where.start)
    return words


def column(words: Words, name: str) -> NDArray[Any]:
    """Return a column of `Tracks` from rows, (n, k), that have it."""
    where, declared = WHERE[name], Tracks.COLUMNS[name]
    part = np.ascontiguousarray(words[:, where])
    values = part.view(np.float32) if declared.dtype == 'f4' else part.astype(declared.dtype)
    if name != 'covariance':
        return values.reshape(len(words), *declared.shape)
    full = np.empty((len(words), 4, 4), np.float32)
    full[:, _UPPER, _RIGHT] = full[:, _RIGHT, _UPPER] = values
    return full


def offsets_ns(words: Words) -> NDArray[np.int64]:
    """Return when rows, (n, k), are, ns from where their span begins."""
    return words[:, _OFFSET].astype(np.int64)


def by_track(words: Words) -> list[Words]:
    """Return the rows of each track, in the order that they have."""
    if not len(words):
        return []
    ordered = words[np.argsort(words[:, ID], kind='stable')]
    return np.split(ordered, np.flatnonzero(np.diff(ordered[:, ID])) + 1)


@dataclass(frozen=True, slots=True)
class Block:
    """
    Messages of `/tracks` one after the other.

    Attributes
    ----------
    began_ns : int
        What the rows' stamps are relative to, ns.
    ticks : (m, 3) uint64 array
        Stamp and log time, ns, and number of rows of each message.
    words : (n, WIDTH) uint32 array
        Their rows.

    """

    began_ns: int
    ticks: NDArray[np.uint64]
    words: Words

    def parts(self) -> Iterator[tuple[tuple[int, int, int], Words]]:
        """Yield stamp, log time, ns, row count and rows of each message."""
        order = np.lexsort([self.words[:, _RANK], self.words[:, _OFFSET]])
        parts = np.split(self.words[order], np.cumsum(self.ticks[:-1, 2], dtype=np.int64))
        yield from zip(self.ticks.tolist(), parts)

    def messages(self) -> Iterator[tuple[Tracks, int]]:
        """Yield the messages, with their log times, ns."""
        for (stamp_ns, log_ns, _), part in self.parts():
            columns = [
                part[:, ID].copy() if name == 'track_id' else column(part, name)
                for name in Tracks.COLUMNS
            ]
            yield Tracks.adopt(stamp_ns, columns), log_ns
