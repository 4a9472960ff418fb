"""Whether the tables of a database agree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, func, select, text

from mctrack_ros.interfaces import Events
from mctrack_ros.store import blocks
from mctrack_ros.store.blocks import Words
from mctrack_ros.store.boxes import load_boxes
from mctrack_ros.store.database import Database
from mctrack_ros.store.rows import Stored, load_journal, unpack_ticks
from mctrack_ros.store.schema import (
    CHUNKS,
    EVENT_MESSAGES,
    EVENTS,
    GROUPS,
    MEMBERS,
    RESTS,
    RUNS,
    TICKS,
    TRACKS,
)
from mctrack_ros.store.writer import box_of

_SPANS = 100
"""Number that are read at a time."""
_EVENT_BYTES = sum(dtype.itemsize * int(np.prod(shape)) for _, dtype, shape, _ in Events.LAYOUT)
_RANK = blocks.WHERE['rank'].start


def check(database: Database) -> list[str]:
    """
    Return what does not agree in a database, a line each; nothing: it is whole.

    Every chunk has its second blob and a box around its places; a span and the journal hold as
    many rows of a stamp as their message had; the journal follows the last span; the table of
    tracks counts what is there; events and memberships belong to messages and groups. SQLite
    checks its file, too.

    Raises
    ------
    StoreError
        If the database refuses.

    """
    with database.snapshot() as connection:
        found = list(_file(connection))
        runs = connection.execute(select(RUNS).order_by(RUNS.c.run_id)).all()
        boxes = 0
        for run in runs:
            checked = _Run(connection, Stored(run.run_id, run.began_ns or 0))
            checked.positions()
            checked.events()
            checked.groups()
            boxes += checked.boxes
            found += [f'run {run.name}: {line}' for line in checked.faults]
        stored = connection.execute(text('SELECT count(*) FROM boxes')).scalar_one()
        if stored != boxes:
            found.append(f'{stored} boxes are of {boxes} chunks with a place')
    return found


def _file(connection: Connection) -> Iterator[str]:
    """Yield what SQLite says of its file."""
    if connection.dialect.name == 'sqlite':
        for (line,) in connection.exec_driver_sql('PRAGMA integrity_check'):
            if line != 'ok':
                yield f'the file: {line}'
        for row in connection.exec_driver_sql('PRAGMA foreign_key_check'):
            yield f'the file: a row of {row[0]} belongs to none of {row[2]}'


class _Run:
    """A run that is checked: what is wrong with it, and how many of its chunks have a box."""

    def __init__(self, connection: Connection, stored: Stored) -> None:
        self._connection, self._stored = connection, stored
        self._last_ns = -1
        self._totals: dict[int, tuple[int, int, int]] = {}
        self.faults: list[str] = []
        self.boxes = 0

    def positions(self) -> None:
        """Check spans, chunks, journal and the table of tracks."""
        asked = select(TICKS.c.span, TICKS.c.ticks).where(TICKS.c.run_id == self._stored.run)
        spans = self._connection.execute(asked.order_by(TICKS.c.span)).all()
        for start in range(0, len(spans), _SPANS):
            self._spans(spans[start : start + _SPANS])
        in_span = CHUNKS.join(
            TICKS, (TICKS.c.run_id == CHUNKS.c.run_id) & (TICKS.c.span == CHUNKS.c.span)
        )
        known, stored = (
            self._count(select(func.count()).select_from(each)) for each in (in_span, CHUNKS)
        )
        if known != stored:
            self.faults.append(f'{stored - known} chunks are of spans without messages')
        last_span = spans[-1].span if spans else -1
        for block in load_journal(self._connection, self._stored):
            span = self._stored.span(block.began_ns)
            if span <= last_span:
                self.faults.append(f'the journal holds span {span}, which is complete')
            self._messages(f'the journal of span {span}', span, block.ticks, block.words)
        self._tracks()

    def events(self) -> None:
        """Check that every event is of a message, and whole."""
        run = self._stored.run
        messages = {
            row.number: (row.topic, row.stamp_ns)
            for row in self._connection.execute(
                select(EVENT_MESSAGES).where(EVENT_MESSAGES.c.run_id == run)
            )
        }
        asked = select(EVENTS.c.number, EVENTS.c.topic, EVENTS.c.stamp_ns, EVENTS.c.row)
        for row in self._connection.execute(asked.where(EVENTS.c.run_id == run)):
            if messages.get(row.number) != (row.topic, row.stamp_ns):
                self.faults.append(f'an event of message {row.number} is of none')
            if len(row.row) != _EVENT_BYTES:
                self.faults.append(f'an event of message {row.number} has {len(row.row)} bytes')

    def groups(self) -> None:
        """Check that every membership is of a group, and while there is that group."""
        same = (GROUPS.c.run_id == MEMBERS.c.run_id) & (GROUPS.c.group_id == MEMBERS.c.group_id)
        lasting = (MEMBERS.c.began_ns >= GROUPS.c.began_ns) & (
            MEMBERS.c.ended_ns <= GROUPS.c.ended_ns
        )
        members = select(func.count()).select_from(MEMBERS)
        within = select(func.count()).select_from(MEMBERS.join(GROUPS, same & lasting))
        run = MEMBERS.c.run_id == self._stored.run
        known, stored = (
            self._connection.execute(each.where(run)).scalar_one() for each in (within, members)
        )
        if known != stored:
            self.faults.append(f'{stored - known} memberships are of no group')

    def _spans(self, spans: Sequence[Any]) -> None:
        """Check some spans, one after the other."""
        asked = (
            select(CHUNKS, RESTS.c.rest)
            .outerjoin(RESTS, RESTS.c.chunk_id == CHUNKS.c.chunk_id)
            .where(CHUNKS.c.run_id == self._stored.run)
            .where(CHUNKS.c.span.between(spans[0].span, spans[-1].span))
            .order_by(CHUNKS.c.span, CHUNKS.c.chunk_id)
        )
        rows = self._connection.execute(asked).all()
        boxes = load_boxes(self._connection, [row.chunk_id for row in rows])
        chunks = {span: list(each) for span, each in groupby(rows, key=lambda row: row.span)}
        for span in spans:
            words = [self._chunk(row, boxes) for row in chunks.get(span.span, [])]
            together = np.concatenate([np.zeros((0, blocks.WIDTH), np.uint32), *words])
            self._messages(f'span {span.span}', span.span, unpack_ticks(span.ticks), together)

    def _chunk(self, row: Row[Any], boxes: dict[int, Any]) -> Words:
        """Check a chunk; return its rows."""
        name = f'chunk {row.chunk_id}'
        places = blocks.unpack(row.places, blocks.PLACES_WIDTH)
        rest = np.zeros((0, blocks.REST_WIDTH), np.uint32)
        if row.rest is None:
            self.faults.append(f'{name} has no second blob')
        else:
            rest = blocks.unpack(row.rest, blocks.REST_WIDTH)
            if len(rest) != len(places):
                self.faults.append(f'{name} has {len(places)} places and {len(rest)} others')
        if len(rest) != len(places):
            rest = np.zeros((len(places), blocks.REST_WIDTH), np.uint32)
        ids = np.full((len(places), 1), row.track_id, np.uint32)
        words = np.concatenate([ids, places, rest], axis=1)
        self._box(name, boxes.get(row.chunk_id), box_of(self._stored, row.span, words))
        if (np.diff(blocks.offsets_ns(words)) < 0).any():
            self.faults.append(f'{name} is not in the order of time')
        return words

    def _box(self, name: str, box: Any, wanted: Any) -> None:
        """Check the box of a chunk, against that of its places; count it."""
        self.boxes += wanted is not None
        if (box is None) != (wanted is None) or (box and wanted and not box.holds(wanted)):
            self.faults.append(f'{name} has another box than its places')

    def _messages(self, name: str, span: int, ticks: NDArray[np.uint64], words: Words) -> None:
        """Check that rows are those of messages, which follow the ones before; count them."""
        stamps = ticks[:, 0].astype(np.int64)
        if any(one >= other for one, other in pairwise([self._last_ns, *stamps.tolist()])):
            self.faults.append(f'{name}: stamps are not ascending')
        self._last_ns = int(stamps[-1])
        if any(self._stored.span(stamp) != span for stamp in stamps.tolist()):
            self.faults.append(f'{name}: a stamp is of another span')
        of_rows = self._stored.stamps_ns(span, words)
        held, counts = np.unique(of_rows, return_counts=True)
        expected = {stamp: count for stamp, _, count in ticks.tolist() if count}
        if dict(zip(held.tolist(), counts.tolist())) != expected:
            self.faults.append(f'{name}: {len(words)} rows, its messages had others')
        ranks = np.column_stack([of_rows, words[:, _RANK]])
        if len(np.unique(ranks, axis=0)) != len(ranks):
            self.faults.append(f'{name}: two rows have one place in a message')
        for part in blocks.by_track(words[np.argsort(of_rows, kind='stable')]):
            track, mine = int(part[0, blocks.ID]), self._stored.stamps_ns(span, part)
            first, _, count = self._totals.get(track, (int(mine[0]), 0, 0))
            self._totals[track] = first, int(mine[-1]), count + len(mine)

    def _tracks(self) -> None:
        asked = select(TRACKS).where(TRACKS.c.run_id == self._stored.run)
        stored = {
            row.track_id: (row.began_ns, row.ended_ns, row.positions)
            for row in self._connection.execute(asked)
        }
        for track in sorted(stored.keys() | self._totals.keys()):
            if stored.get(track) != self._totals.get(track):
                self.faults.append(
                    f'track {track}: the table says {stored.get(track)}, '
                    f'its rows {self._totals.get(track)}'
                )

    def _count(self, asked: Any) -> int:
        found = self._connection.execute(asked.where(CHUNKS.c.run_id == self._stored.run))
        return int(found.scalar_one())
