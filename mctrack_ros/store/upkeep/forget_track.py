"""Deletion of a track with all its traces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, delete, func, insert, select, update

from mctrack_ros.interfaces import EventCode, Events
from mctrack_ros.store import blocks
from mctrack_ros.store.blocks import Words
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.identities import load_identities
from mctrack_ros.store.membership import Memberships, write_memberships
from mctrack_ros.store.rows import Stored, unpack_ticks
from mctrack_ros.store.runs import find_run
from mctrack_ros.store.schema import (
    CHUNKS,
    CORRECTIONS,
    EVENT_MESSAGES,
    EVENTS,
    GROUPS,
    JOURNAL,
    MEMBERS,
    RESTS,
    TICKS,
    TRACKS,
)
from mctrack_ros.store.summary import add_tracks
from mctrack_ros.store.upkeep.retention import forget_chunks
from mctrack_ros.store.writer import EVENTS_TOPIC, insert_chunks

_EVENT = np.dtype([(name, kind, shape) for name, kind, shape, _ in Events.LAYOUT])


@dataclass(frozen=True, slots=True)
class Forgotten:
    """
    What was deleted of somebody.

    Attributes
    ----------
    rows, events : int
        Rows of tracks, and events that named them.
    goes_on : bool
        Whether they are in the span that is being written, if somebody writes: then more comes.

    """

    rows: int
    events: int
    goes_on: bool


def forget_track(database: Database, track: int, run: str = '') -> Forgotten:
    """
    Delete a track with all its traces, under all ids of that life, as corrections say.

    Rows of others who were called by one of these ids, or came to theirs by corrections, are
    called by their own from then on: those corrections are gone, too.

    Parameters
    ----------
    database : Database
        With the run.
    track : int
        The track, as it is known now.
    run : str
        The run; it need not be named if there is only one.

    Raises
    ------
    StoreError
        If there is no such run or track, or the database refuses.

    """
    with database.alone() as connection:
        found = find_run(connection, run)
        stored = Stored(found.run_id, found.began_ns or 0)
        if track <= 0:
            raise StoreError(f'{track} is no id of a track')
        deletion = _Deletion(connection, stored, track)
        deletion.positions()
        deletion.memberships()
        deletion.events()
        if not (deletion.rows or deletion.named):
            raise StoreError(f'run {found.name} has no track {track}')
    return Forgotten(
        deletion.rows, deletion.named, deletion.is_in_journal and found.ended_ns is None
    )


class _Deletion:
    """Someone who is deleted from a run."""

    def __init__(self, connection: Connection, stored: Stored, track: int) -> None:
        self._connection, self._stored, self._track = connection, stored, track
        self._identities = load_identities(connection, stored)
        self._concerned = _connected(connection, stored, track)
        self._memberships = Memberships()
        self.rows = self.named = 0
        self.is_in_journal = False

    def positions(self) -> None:
        """Delete rows, and write the others' by their own ids; count tracks anew."""
        concerned = TRACKS.c.track_id.in_(self._concerned)
        of_run = TRACKS.c.run_id == self._stored.run
        self._connection.execute(delete(TRACKS).where(of_run & concerned))
        for span, rows in self._spans():
            words = [self._chunk(row) for row in rows]
            chunks = [row.chunk_id for row in rows]
            self._span(span, chunks, np.concatenate(words))
        journal = select(JOURNAL).where(JOURNAL.c.run_id == self._stored.run)
        for row in self._connection.execute(journal.order_by(JOURNAL.c.number)).all():
            before = blocks.unpack(row.words, blocks.WIDTH)
            mine, deleted = np.isin(before[:, blocks.ID], self._concerned), self.rows
            kept, changed = self._kept(row.span, before[mine])
            self._count(row.span, kept)
            if changed:
                self.is_in_journal |= self.rows > deleted
                after = np.concatenate([before[~mine], kept])
                ticks = self._fewer(unpack_ticks(row.ticks), row.span, before, after)
                values = {'ticks': blocks.pack(ticks), 'words': blocks.pack(after)}
                same = (JOURNAL.c.run_id == row.run_id) & (JOURNAL.c.number == row.number)
                self._connection.execute(update(JOURNAL).where(same).values(values))

    def memberships(self) -> None:
        """Write the memberships of the others anew; delete groups that nobody is left in."""
        concerned = MEMBERS.c.run_id == self._stored.run, MEMBERS.c.track_id.in_(self._concerned)
        asked = select(MEMBERS.c.group_id).where(*concerned).distinct()
        groups = self._connection.execute(asked).scalars().all()
        self._connection.execute(delete(MEMBERS).where(*concerned))
        write_memberships(self._connection, self._memberships.changed(self._stored.run))
        self._rewrite_groups(groups)

    def _rewrite_groups(self, groups: Sequence[int]) -> None:
        """Write some groups anew, as long as their memberships are."""
        rows = self._connection.execute(
            select(
                MEMBERS.c.run_id,
                MEMBERS.c.group_id,
                func.min(MEMBERS.c.began_ns).label('began_ns'),
                func.max(MEMBERS.c.ended_ns).label('ended_ns'),
            )
            .where(MEMBERS.c.run_id == self._stored.run, MEMBERS.c.group_id.in_(groups))
            .group_by(MEMBERS.c.run_id, MEMBERS.c.group_id)
        ).all()
        touched = GROUPS.c.run_id == self._stored.run, GROUPS.c.group_id.in_(groups)
        self._connection.execute(delete(GROUPS).where(*touched))
        if rows:
            self._connection.execute(insert(GROUPS), [row._asdict() for row in rows])

    def events(self) -> None:
        """Delete events that name them, and the corrections of all who are concerned."""
        of_run = EVENTS.c.run_id == self._stored.run
        asked = select(
            EVENTS.c.number, EVENTS.c.line, EVENTS.c.topic, EVENTS.c.stamp_ns, EVENTS.c.row
        )
        touched = set()
        for row in self._connection.execute(asked.where(of_run)).all():
            packed = np.frombuffer(row.row, _EVENT).copy()
            same = of_run & (EVENTS.c.number == row.number) & (EVENTS.c.line == row.line)
            names = _names(packed, row.topic)
            if not any(np.isin(each, self._concerned).any() for each in names):
                continue
            is_correction = (
                packed['event'][0] == EventCode.CORRECTION and row.topic == EVENTS_TOPIC
            )
            lives = [self._lives(each, row.stamp_ns) for each in names]
            if is_correction or any((each == self._track).any() for each in lives):
                self._connection.execute(delete(EVENTS).where(same))
                touched.add(row.number)
                self.named += not is_correction
                continue
            for each, life in zip(names, lives):
                each[...] = life
            values = {'row': packed.tobytes(), 'track_id': int(packed['track_id'][0])}
            self._connection.execute(update(EVENTS).where(same).values(values))
        self._forget_messages(touched)

    def _forget_messages(self, numbers: set[int]) -> None:
        """Delete those of some messages of events that are empty now, and all corrections."""
        of_run = EVENTS.c.run_id == self._stored.run
        left = set(self._connection.execute(select(EVENTS.c.number).where(of_run)).scalars())
        for number in numbers - left:
            message = EVENT_MESSAGES.c.number == number
            of_this = EVENT_MESSAGES.c.run_id == self._stored.run
            self._connection.execute(delete(EVENT_MESSAGES).where(of_this, message))
        self._connection.execute(
            delete(CORRECTIONS).where(
                CORRECTIONS.c.run_id == self._stored.run,
                CORRECTIONS.c.old_id.in_(self._concerned),
            )
        )

    def _spans(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield the chunks of those who are concerned, span by span."""
        asked = (
            select(CHUNKS, RESTS.c.rest)
            .join(RESTS, RESTS.c.chunk_id == CHUNKS.c.chunk_id)
            .where(CHUNKS.c.run_id == self._stored.run)
            .where(CHUNKS.c.track_id.in_(self._concerned))
            .order_by(CHUNKS.c.span, CHUNKS.c.chunk_id)
        )
        rows = self._connection.execute(asked).all()
        for span, each in groupby(rows, key=lambda row: row.span):
            yield span, list(each)

    def _chunk(self, row: Any) -> Words:
        places = blocks.unpack(row.places, blocks.PLACES_WIDTH)
        rest = blocks.unpack(row.rest, blocks.REST_WIDTH)
        ids = np.full((len(places), 1), row.track_id, np.uint32)
        return np.concatenate([ids, places, rest], axis=1)

    def _span(self, span: int, chunks: list[int], before: Words) -> None:
        """Write what is left of a span in place of its chunks."""
        kept, changed = self._kept(span, before)
        self._count(span, kept)
        if not changed:
            return
        run = self._stored.run
        same = (TICKS.c.run_id == run) & (TICKS.c.span == span)
        ticks = unpack_ticks(
            self._connection.execute(select(TICKS.c.ticks).where(same)).scalar_one()
        )
        fewer = self._fewer(ticks, span, before, kept)
        self._connection.execute(update(TICKS).where(same).values(ticks=blocks.pack(fewer)))
        forget_chunks(self._connection, chunks)
        parts = blocks.by_track(kept)
        largest = select(func.max(CHUNKS.c.chunk_id)).where(CHUNKS.c.run_id == run)
        last = self._connection.execute(largest).scalar()
        while len(chunks) < len(parts):
            chunks.append(max(chunks[-1], last if last is not None else run << 32) + 1)
        insert_chunks(self._connection, self._stored, span, dict(zip(chunks, parts)))

    def _kept(self, span: int, words: Words) -> tuple[Words, bool]:
        """Return the rows that stay, by their own ids, as time goes; and whether any changed."""
        words = words[np.argsort(blocks.offsets_ns(words), kind='stable')]
        stamps = self._stored.stamps_ns(span, words)
        ids = words[:, blocks.ID].astype(np.int64)
        lives = self._identities.lives(ids, stamps)
        order = np.lexsort([lives != ids, stamps, lives])
        again = np.zeros(len(words), np.bool_)
        again[order[1:]] = (np.diff(lives[order]) == 0) & (np.diff(stamps[order]) == 0)
        again &= lives != ids
        gone = lives == self._track
        self.rows += int(gone.sum())
        kept = words[~(gone | again)].copy()
        kept[:, blocks.ID] = lives[~(gone | again)]
        return kept, len(kept) < len(words) or bool((lives != ids).any())

    def _count(self, span: int, words: Words) -> None:
        """Count the rows that stay in the table of tracks, and their memberships."""
        stamps = self._stored.stamps_ns(span, words)
        order = np.argsort(stamps, kind='stable')
        add_tracks(self._connection, self._stored, (stamps[order], words[order]))
        for part in blocks.by_track(words[order]):
            group = blocks.column(part, 'group')
            self._memberships.add(
                int(part[0, blocks.ID]), self._stored.stamps_ns(span, part), group
            )

    def _fewer(
        self, ticks: NDArray[np.uint64], span: int, before: Words, after: Words
    ) -> NDArray[np.uint64]:
        """Return the ticks with the counts of what is left of their rows."""
        fewer = ticks.copy()
        stamps = ticks[:, 0].astype(np.int64)
        for words, sign in ((before, -1), (after, 1)):
            at = np.searchsorted(stamps, self._stored.stamps_ns(span, words))
            counts = np.bincount(at, minlength=len(ticks)).astype(np.int64)
            fewer[:, 2] = (fewer[:, 2].astype(np.int64) + sign * counts).astype(np.uint64)
        return fewer

    def _lives(self, ids: NDArray[Any], stamp_ns: int) -> NDArray[np.int64]:
        flat = ids.reshape(-1).astype(np.int64)
        return self._identities.lives(flat, np.full(len(flat), stamp_ns)).reshape(ids.shape)


def _connected(connection: Connection, stored: Stored, track: int) -> list[int]:
    """Return all ids that corrections lead to from one, and itself."""
    asked = select(CORRECTIONS.c.old_id, CORRECTIONS.c.new_id)
    pairs = connection.execute(asked.where(CORRECTIONS.c.run_id == stored.run)).all()
    found, size = {track}, 0
    while len(found) > size:
        size = len(found)
        for pair in pairs:
            if found & set(pair):
                found |= set(pair)
    return sorted(found)


def _names(packed: NDArray[Any], topic: str) -> list[NDArray[Any]]:
    """Return the columns of an event that hold ids of fusion's tracks; its own, not copies."""
    names = ['track_id', 'other_tracks']
    if topic == EVENTS_TOPIC:
        names += ['others', 'old_id', 'new_id']
    return [packed[name] for name in names]
