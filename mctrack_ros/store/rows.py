"""Rows of tracks read from a database."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, Row, Select, bindparam, select

from mctrack_ros.interfaces import REPORTED
from mctrack_ros.store import blocks
from mctrack_ros.store.blocks import Block, Words
from mctrack_ros.store.schema import CHUNKS, JOURNAL, RESTS, TICKS

SPAN_NS = 2_000_000_000
"""Of a chunk: longer ones are smaller, and more of each is read in vain."""
_LAST_SPAN = 2**31 - 1  # what a column of 32 bits holds
_JOURNALED = select(JOURNAL).where(JOURNAL.c.run_id == bindparam('run')).order_by(JOURNAL.c.number)
_AT_ONCE = 500
"""Numbers named in one statement; databases have a limit."""


@dataclass(frozen=True, slots=True)
class Stored:
    """
    What is known of a run.

    Attributes
    ----------
    run : int
        Its number.
    began_ns : int
        Stamp of its first tick, ns.

    """

    run: int
    began_ns: int

    def span(self, stamp_ns: int) -> int:
        """Return the span of a stamp, ns; one before the first tick is in the first."""
        return min(max(0, (stamp_ns - self.began_ns) // SPAN_NS), _LAST_SPAN)

    def span_ns(self, span: int) -> int:
        """Return where a span begins, ns."""
        return self.began_ns + span * SPAN_NS

    def stamps_ns(self, span: int, words: Words) -> NDArray[np.int64]:
        """Return when rows, (n, k), of a span are, ns."""
        return self.span_ns(span) + blocks.offsets_ns(words)


@dataclass(frozen=True, slots=True)
class TrackRows:
    """
    Rows of tracks.

    Attributes
    ----------
    stamp_ns : (n,) int64 array
        Ascending.
    track_id : (n,) int64 array
        As they were called at that time.
    life : (n,) int64 array
        Whom they are taken for.
    words : (n, k) uint32 array
        Their ids and places, and the other columns if they were asked for.

    """

    stamp_ns: NDArray[np.int64]
    track_id: NDArray[np.int64]
    life: NDArray[np.int64]
    words: Words

    def __len__(self) -> int:
        """Return how many they are."""
        return len(self.stamp_ns)

    def column(self, name: str) -> NDArray[Any]:
        """Return a column of `Tracks`."""
        return blocks.column(self.words, name)

    def position(self) -> NDArray[np.float64]:
        """Return where they are, (n, 2), m."""
        return self.column('position')[:, :2].astype(np.float64)

    def select(self, index: NDArray[Any]) -> Self:
        """Return some of them."""
        return replace(
            self,
            stamp_ns=self.stamp_ns[index],
            track_id=self.track_id[index],
            life=self.life[index],
            words=self.words[index],
        )

    def reported(self) -> Self:
        """Return those that the tracker stands for and that have a place."""
        placed = np.isfinite(self.column('position')[:, :2]).all(axis=1)
        return self.select(placed & np.isin(self.column('status'), REPORTED))


def load_rows(
    connection: Connection,
    stored: Stored,
    between_ns: tuple[int, int],
    *,
    tracks: Collection[int] | None = None,
    chunks: Sequence[int] | None = None,
    whole: bool = False,
) -> TrackRows:
    """
    Return rows of a run, from a stamp until before another, ns.

    Parameters
    ----------
    connection : Connection
        To the database.
    stored : Stored
        The run.
    between_ns : (int, int)
        From when until before when, ns.
    tracks : collection of int, optional
        Only rows of these ids, as they were called at the time.
    chunks : sequence of int, optional
        Only rows of these chunks, and those of the journal.
    whole : bool
        Whether all columns are read, or places alone.

    """
    stamps, words = _of_chunks(connection, stored, between_ns, tracks, chunks, whole)
    for block in load_journal(connection, stored):
        added = block.words[:, : words.shape[1]]
        if tracks is not None:
            added = added[np.isin(added[:, blocks.ID], list(tracks))]
        stamps = np.concatenate([stamps, block.began_ns + blocks.offsets_ns(added)])
        words = np.concatenate([words, added])
    kept = np.flatnonzero((stamps >= between_ns[0]) & (stamps < between_ns[1]))
    kept = kept[np.argsort(stamps[kept], kind='stable')]
    ids = words[kept, blocks.ID].astype(np.int64)
    return TrackRows(stamps[kept], ids, ids, words[kept])


def load_blocks(connection: Connection, stored: Stored) -> Iterator[Block]:
    """Yield all messages of a run, span by span."""
    yield from load_spans(connection, stored)
    yield from load_journal(connection, stored)


def load_spans(
    connection: Connection, stored: Stored, first: int = 0, most: int | None = None
) -> Iterator[Block]:
    """Yield the messages of complete spans from a first one on, of so many at most."""
    asked = select(TICKS.c.span, TICKS.c.ticks).where(
        TICKS.c.run_id == stored.run, TICKS.c.span >= first
    )
    in_run = CHUNKS.c.run_id == stored.run
    for span, ticks in connection.execute(asked.order_by(TICKS.c.span).limit(most)).all():
        began_ns = stored.span_ns(span)
        rows = _chunks(connection, in_run & (CHUNKS.c.span == span), whole=True)
        yield Block(began_ns, unpack_ticks(ticks), _words(rows, whole=True)[0])


def load_journal(connection: Connection, stored: Stored) -> Iterator[Block]:
    """Yield what is journaled of the span that is not complete."""
    for row in connection.execute(_JOURNALED, {'run': stored.run}).all():
        words = blocks.unpack(row.words, blocks.WIDTH)
        yield Block(stored.span_ns(row.span), unpack_ticks(row.ticks), words)


def load_stamps(
    connection: Connection, stored: Stored, between_ns: tuple[int, int]
) -> NDArray[np.int64]:
    """Return the stamps of messages from one until before another, (m,), ascending, ns."""
    first, last = (stored.span(stamp_ns) for stamp_ns in between_ns)
    asked = select(TICKS.c.ticks).where(TICKS.c.run_id == stored.run).order_by(TICKS.c.span)
    blobs = [*connection.execute(asked.where(TICKS.c.span.between(first, last))).scalars()]
    blobs += [row.ticks for row in connection.execute(_JOURNALED, {'run': stored.run})]
    ticks, _ = blocks.unpack_all(blobs, 3, np.uint64)
    stamps: NDArray[np.int64] = ticks[:, 0].astype(np.int64)
    return stamps[(stamps >= between_ns[0]) & (stamps < between_ns[1])]


def unpack_ticks(blob: bytes) -> NDArray[np.uint64]:
    """Return stamps, log times and row counts of messages, (m, 3)."""
    ticks: NDArray[np.uint64] = blocks.unpack(blob, 3, np.uint64)
    return ticks


def _of_chunks(
    connection: Connection,
    stored: Stored,
    between_ns: tuple[int, int],
    tracks: Collection[int] | None,
    chunks: Sequence[int] | None,
    whole: bool,
) -> tuple[NDArray[np.int64], Words]:
    """Return stamps, ns, and columns of the rows of chunks."""
    first, last = (stored.span(stamp_ns) for stamp_ns in between_ns)
    condition = (CHUNKS.c.run_id == stored.run) & CHUNKS.c.span.between(first, last)
    conditions: list[ColumnElement[bool]] = [condition]
    if chunks is not None:
        conditions = [CHUNKS.c.chunk_id.in_(part) for part in _parts(chunks)]
    elif tracks is not None:
        conditions = [condition & CHUNKS.c.track_id.in_(part) for part in _parts(tracks)]
    found = [row for each in conditions for row in _chunks(connection, each, whole)]
    words, counts = _words(found, whole)
    began_ns = np.array([stored.span_ns(row.span) for row in found], np.int64)
    return np.repeat(began_ns, counts) + blocks.offsets_ns(words), words


def _chunks(
    connection: Connection, condition: ColumnElement[bool], whole: bool
) -> Sequence[Row[Any]]:
    asked: Select[Any] = select(CHUNKS.c.span, CHUNKS.c.track_id, CHUNKS.c.places)
    if whole:
        asked = asked.add_columns(RESTS.c.rest).join(RESTS, RESTS.c.chunk_id == CHUNKS.c.chunk_id)
    return connection.execute(asked.where(condition)).all()


def _words(rows: Sequence[Row[Any]], whole: bool) -> tuple[Words, NDArray[np.intp]]:
    """Return the columns of chunks, one after the other, and how many rows each has."""
    places, counts = blocks.unpack_all([row.places for row in rows], blocks.PLACES_WIDTH)
    ids = np.array([row.track_id for row in rows], np.uint32)
    parts = [np.repeat(ids, counts)[:, None], places]
    if whole:
        parts.append(blocks.unpack_all([row.rest for row in rows], blocks.REST_WIDTH)[0])
    return np.concatenate(parts, axis=1), counts


def _parts(numbers: Collection[int]) -> Iterator[list[int]]:
    listed = list(numbers)
    for start in range(0, len(listed), _AT_ONCE):
        yield listed[start : start + _AT_ONCE]
