"""Write tracks, events and corrections of a run into a trajectory database."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, delete, func, insert, select, update

from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.recording.closing import Closing
from mctrack_ros.store import blocks
from mctrack_ros.store.blocks import Words
from mctrack_ros.store.boxes import Box, insert_boxes
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.identities import since_when
from mctrack_ros.store.membership import Memberships, write_memberships
from mctrack_ros.store.rows import SPAN_NS, Stored, load_journal, unpack_ticks
from mctrack_ros.store.runs import NewRun, begin_run, write_progress
from mctrack_ros.store.schema import (
    CHUNKS,
    CORRECTIONS,
    DESCRIPTIONS,
    EVENT_MESSAGES,
    EVENTS,
    JOURNAL,
    RESTS,
    RUNS,
    TICKS,
)
from mctrack_ros.store.summary import add_tracks

EVENTS_TOPIC = '/events'
FLUSH_S = 0.5
"""Most that is lost if the process is killed."""
_MOST_WAITING = 100_000
"""Rows that wait for the next transaction; an import is faster than its clock."""


@dataclass(slots=True)
class _Span:
    """
    Messages of one span: stamps, log times and row counts, and the rows as numbers.

    So many of them are journaled.
    """

    number: int
    ticks: list[tuple[int, int, int]] = field(default_factory=list)
    words: list[Words] = field(default_factory=list)
    journaled: int = 0

    def new_words(self) -> list[Words]:
        """Return the rows of the messages that are not in the journal."""
        return self.words[self.journaled :]

    def packed(self) -> dict[str, bytes]:
        """Return the messages that are not in the journal as blobs."""
        words = blocks.pack(np.concatenate(self.new_words()))
        return {'ticks': self.packed_ticks(self.journaled), 'words': words}

    def packed_ticks(self, start: int = 0) -> bytes:
        """Return stamps, log times and row counts as a blob."""
        return blocks.pack(np.array(self.ticks[start:], np.uint64))


@dataclass(slots=True)
class _Waiting:
    """What the next transaction writes."""

    spans: list[_Span] = field(default_factory=list)
    events: list[tuple[int, str, int, Events]] = field(default_factory=list)
    descriptions: list[dict[str, Any]] = field(default_factory=list)
    rows: int = 0


class TrajectoryWriter(Closing):
    """
    Write a run into a trajectory database, in batches.

    Every half second all that has come is written in one transaction: complete chunks, and the
    span that is not complete as a journal. If the process is killed, that is what is lost; the
    database stays whole.

    Parameters
    ----------
    database : Database
        Where it is written.
    run : NewRun
        The run.
    resume : bool
        Whether a run of that name that is there already is continued.
    source : str
        Whose messages are written; none: nobody has to know how far they are.
    clock : callable
        Tells the time since some instant, s.

    Attributes
    ----------
    position : int
        Of the last message in its source, set before it is written; kept in the same transaction.

    Raises
    ------
    StoreError
        If the database refuses, or the run is there already and not to be continued.

    """

    def __init__(
        self,
        database: Database,
        run: NewRun,
        *,
        resume: bool = False,
        source: str = '',
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._database, self._clock = database, clock
        self._name, self._flushed_s = run.name, clock()
        self._source, self.position = source, 0
        self._waiting, self._open = _Waiting(), _Span(0)
        self._memberships = Memberships()
        with database.connected() as connection:
            self._run, self._began_ns = begin_run(connection, run, resume=resume)
            self._last_ns = self._recover(connection)
            self._chunk = 1 + _largest(connection, CHUNKS.c.chunk_id, CHUNKS, self._run)
            self._chunk = max(self._chunk, self._run << 32)
            self._message = 1 + max(
                _largest(connection, table.c.number, table, self._run)
                for table in (EVENT_MESSAGES, DESCRIPTIONS, JOURNAL)
            )

    @property
    def last_ns(self) -> int | None:
        """Stamp of the last tick, ns; None: there is none yet."""
        return self._last_ns

    def write_tracks(self, rows: Tracks, log_ns: int | None = None) -> None:
        """
        Append a message of `/tracks`; its log time, ns, is its stamp unless given.

        Raises
        ------
        StoreError
            If its stamp is not after the one before, or the database refuses: then everything
            waits for the next time.

        """
        if self._last_ns is not None and rows.stamp_ns <= self._last_ns:
            raise StoreError(
                f'run {self._name}: time steps back from {self._last_ns} to {rows.stamp_ns} ns: '
                'write what follows as another run'
            )
        if self._began_ns is None:
            self._began_ns = rows.stamp_ns
        number, since_ns = divmod(rows.stamp_ns - self._began_ns, SPAN_NS)
        if number != self._open.number:
            self._close_span(number)
        self._last_ns = rows.stamp_ns
        logged_ns = rows.stamp_ns if log_ns is None else log_ns
        self._open.ticks.append((rows.stamp_ns, logged_ns, len(rows)))
        self._open.words.append(blocks.words_of(rows, rows.stamp_ns - since_ns))
        self._waiting.rows += len(rows)
        self._flush_if_due()

    def write_events(
        self, rows: Events, topic: str = EVENTS_TOPIC, log_ns: int | None = None
    ) -> None:
        """Append a message of events, after the tracks of its tick; raises `StoreError`."""
        logged_ns = rows.stamp_ns if log_ns is None else log_ns
        self._waiting.events.append((self._message, topic, logged_ns, rows))
        self._message += 1
        self._waiting.rows += len(rows)
        self._flush_if_due()

    def write_description(self, text: str, log_ns: int) -> None:
        """Append what `/site` said; raises `StoreError`."""
        self._waiting.descriptions.append(
            {'run_id': self._run, 'number': self._message, 'log_ns': log_ns, 'text': text}
        )
        self._message += 1

    def flush(self) -> None:
        """
        Write all that has come.

        Raises
        ------
        StoreError
            If the database refuses: then everything waits for the next time.

        """
        self._flush(is_over=False)

    def close(self) -> None:
        """Finish the run: the open span becomes chunks; raises `StoreError`."""
        self._close_span(self._open.number + 1)
        self._flush(is_over=True)

    def _recover(self, connection: Connection) -> int | None:
        """Take up what an earlier writer journaled; return the stamp of its last tick, ns."""
        if self._began_ns is None:
            return None
        stored = Stored(self._run, self._began_ns)
        last = select(TICKS.c.span, TICKS.c.ticks).where(TICKS.c.run_id == self._run)
        row = connection.execute(last.order_by(TICKS.c.span.desc()).limit(1)).one_or_none()
        ticks = []
        if row is not None:
            self._open.number = row.span + 1
            ticks = unpack_ticks(row.ticks)[:, 0].tolist()
            self._memberships.take_up(connection, self._run, ticks[-1])
        for block in load_journal(connection, stored):
            self._open.number = stored.span(block.began_ns)
            for (stamp_ns, log_ns, count), words in block.parts():
                self._open.ticks.append((stamp_ns, log_ns, count))
                self._open.words.append(words)
                ticks.append(stamp_ns)
        self._open.journaled = len(self._open.ticks)
        return max(ticks, default=None)

    def _close_span(self, number: int) -> None:
        if self._open.ticks:
            self._waiting.spans.append(self._open)
        self._open = _Span(number)

    def _flush_if_due(self) -> None:
        if self._waiting.rows >= _MOST_WAITING or self._clock() - self._flushed_s >= FLUSH_S:
            self.flush()

    def _flush(self, *, is_over: bool) -> None:
        self._flushed_s = self._clock()
        waiting = self._waiting
        chunk, number = self._chunk, self._message
        memberships = self._memberships.copy()
        with self._database.connected() as connection:
            if self._began_ns is not None:
                stored = Stored(self._run, self._began_ns)
                values: dict[str, Any] = {'began_ns': self._began_ns}
                values |= {'ended_ns': self._last_ns} if is_over else {}
                connection.execute(update(RUNS).where(RUNS.c.run_id == self._run).values(values))
                for span in waiting.spans:
                    chunk = self._write_span(connection, stored, span, chunk, memberships)
                add_tracks(connection, stored, _new_rows(stored, [*waiting.spans, self._open]))
                write_memberships(connection, memberships.changed(self._run))
                self._journal(connection, number)
            if waiting.descriptions:
                connection.execute(insert(DESCRIPTIONS), waiting.descriptions)
            if waiting.events:
                self._write_events(connection, waiting.events)
            if self._source:
                write_progress(connection, self._source, self.position, self._run)
        self._chunk, self._message = chunk, number + 1
        self._open.journaled, self._memberships = len(self._open.ticks), memberships
        self._waiting = _Waiting()

    def _journal(self, connection: Connection, number: int) -> None:
        """Put what is new of the open span into the journal, and take out what came before it."""
        gone = (JOURNAL.c.run_id == self._run) & (JOURNAL.c.span < self._open.number)
        connection.execute(delete(JOURNAL).where(gone))
        if self._open.new_words():
            key = {'run_id': self._run, 'number': number, 'span': self._open.number}
            connection.execute(insert(JOURNAL), {**key, **self._open.packed()})

    def _write_span(
        self,
        connection: Connection,
        stored: Stored,
        span: _Span,
        chunk: int,
        memberships: Memberships,
    ) -> int:
        """Write the chunks of a span; return the number of the next one."""
        parts = blocks.by_track(np.concatenate(span.words))
        chunks = dict(enumerate(parts, chunk))
        for words in parts:
            stamps, group = stored.stamps_ns(span.number, words), blocks.column(words, 'group')
            memberships.add(int(words[0, blocks.ID]), stamps, group)
        row = {'run_id': self._run, 'span': span.number, 'ticks': span.packed_ticks()}
        connection.execute(insert(TICKS), row)
        insert_chunks(connection, stored, span.number, chunks)
        return chunk + len(chunks)

    def _write_events(
        self, connection: Connection, events: list[tuple[int, str, int, Events]]
    ) -> None:
        messages, rows, corrections = [], [], []
        for number, topic, log_ns, message in events:
            stamp_ns = message.stamp_ns
            key = {'run_id': self._run, 'number': number, 'stamp_ns': stamp_ns}
            messages.append({**key, 'topic': topic, 'log_ns': log_ns})
            for line in range(len(message)):
                rows.append({**key, 'line': line, 'topic': topic, **_event(message, line)})
                if topic == EVENTS_TOPIC and message.event[line] == EventCode.CORRECTION:
                    said = self._correction(connection, message, line)
                    corrections.append({**key, 'line': line, **said})
        for table, lines in (
            (EVENT_MESSAGES, messages),
            (EVENTS, rows),
            (CORRECTIONS, corrections),
        ):
            if lines:
                connection.execute(insert(table), lines)

    def _correction(self, connection: Connection, message: Events, line: int) -> dict[str, Any]:
        """Return what an event corrects, and since when."""
        old_id, new_id = int(message.old_id[line]), int(message.new_id[line])
        since_ns = message.stamp_ns
        if self._began_ns is not None:
            stored = Stored(self._run, self._began_ns)
            since_ns = since_when(connection, stored, message.stamp_ns, old_id, new_id)
        return {
            'since_ns': since_ns,
            'old_id': old_id,
            'new_id': new_id,
            'probability': float(message.probability[line]),
        }


def _largest(connection: Connection, column: Any, table: Any, run: int) -> int:
    """Return the largest number of a run in a table; -1: it has none."""
    asked = select(func.max(column)).where(table.c.run_id == run)
    found = connection.execute(asked).scalar()
    return -1 if found is None else int(found)


def _new_rows(stored: Stored, spans: Sequence[_Span]) -> tuple[NDArray[np.int64], Words]:
    """Return stamps, ns, and rows of spans that are not journaled, in the order of time."""
    parts = [(span.number, words) for span in spans for words in span.new_words()]
    stamps = [stored.stamps_ns(number, words) for number, words in parts]
    empty = np.zeros((0, blocks.WIDTH), np.uint32)
    return (
        np.concatenate([np.zeros(0, np.int64), *stamps]),
        np.concatenate([empty, *(words for _, words in parts)]),
    )


def insert_chunks(
    connection: Connection, stored: Stored, span: int, chunks: Mapping[int, Words]
) -> None:
    """Insert chunks of a span, rows of a track each, by their numbers: both blobs and the box."""
    rows, rests, boxes = [], [], []
    for chunk, words in chunks.items():
        places, rest = np.split(words[:, 1:], [blocks.PLACES_WIDTH], axis=1)
        keys = {'run_id': stored.run, 'span': span, 'track_id': int(words[0, blocks.ID])}
        rows.append({'chunk_id': chunk, **keys, 'places': blocks.pack(places)})
        rests.append({'chunk_id': chunk, 'rest': blocks.pack(rest)})
        box = box_of(stored, span, words)
        boxes += [(chunk, box)] if box else []
    if rows:
        connection.execute(insert(CHUNKS), rows)
        connection.execute(insert(RESTS), rests)
        insert_boxes(connection, boxes)


def box_of(stored: Stored, span: int, words: Words) -> Box | None:
    """Return the box around the places of rows, (n, k), of a span; None: none is known."""
    position = blocks.column(words, 'position')
    known = np.isfinite(position[:, :2]).all(axis=1)
    if not known.any():
        return None
    place = position[known, :2].astype(float)
    since_ns = stored.stamps_ns(span, words)[known] - stored.began_ns
    (left, low), (right, high) = place.min(axis=0).tolist(), place.max(axis=0).tolist()
    times = float(since_ns.min()) * 1e-9, float(since_ns.max()) * 1e-9
    return Box(stored.run, *times, left, right, low, high)


def _event(message: Events, line: int) -> dict[str, Any]:
    x, y, _ = message.position[line].tolist()
    return {
        'event': int(message.event[line]),
        'track_id': int(message.track_id[line]),
        'x': x if np.isfinite(x) else None,
        'y': y if np.isfinite(y) else None,
        'row': b''.join(getattr(message, name)[line].tobytes() for name in Events.COLUMNS),
    }


def events_of(stamp_ns: int, rows: list[bytes]) -> Events:
    """Return a message of events from how its rows are stored."""
    layout = np.dtype([(name, kind, shape) for name, kind, shape, _ in Events.LAYOUT])
    packed = np.frombuffer(b''.join(rows), layout)
    columns = [np.ascontiguousarray(packed[name]) for name in Events.COLUMNS]
    return Events.adopt(stamp_ns, columns)
