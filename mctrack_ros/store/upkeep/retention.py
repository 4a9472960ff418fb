"""How long each kind of data is kept."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

from sqlalchemy import Connection, delete, exists, func, select, update

from mctrack_ros.interfaces import EventCode
from mctrack_ros.store import blocks
from mctrack_ros.store.boxes import delete_boxes
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.rows import SPAN_NS, Stored, load_journal, load_rows
from mctrack_ros.store.schema import (
    CHUNKS,
    CORRECTIONS,
    DESCRIPTIONS,
    EVENT_MESSAGES,
    EVENTS,
    GROUPS,
    JOURNAL,
    MEMBERS,
    RESTS,
    RUN_CAMERAS,
    RUNS,
    TICKS,
    TRACKS,
    VIDEOS,
)
from mctrack_ros.store.writer import EVENTS_TOPIC

_UNITS = {'s': 1, 'm': 60, 'h': 3600, 'd': 86400}
_AGE = re.compile(r'(\d+(?:\.\d+)?)([smhd])')
_SPANS = 300
"""Number that are deleted in one transaction: meanwhile other writers wait."""
_OF_RUN = (
    *(JOURNAL, TICKS, TRACKS, MEMBERS, GROUPS, EVENTS, EVENT_MESSAGES, CORRECTIONS),
    *(DESCRIPTIONS, RUN_CAMERAS),
)
"""
Tables of what belongs to a run, but for chunks and what belongs to them.

How far a source is written stays: nothing of it is written again.
"""


@dataclass(frozen=True, slots=True)
class Keep:
    """
    How long each kind of data is kept, s; None: for ever.

    Attributes
    ----------
    positions : float, optional
        Of tracks, with groups and memberships.
    events : float, optional
        Of fusion and cameras.
    corrections : float, optional
        Of identities; without them, ids are those of the time.
    videos : float, optional
        Links to videos.

    """

    positions: float | None = None
    events: float | None = None
    corrections: float | None = None
    videos: float | None = None

    @classmethod
    def parsed(cls, text: str) -> Self:
        """
        Read an age for all kinds, ``30d``, or ages by kind, ``positions=30d,events=90d``.

        Units are s, m, h and d.

        Raises
        ------
        StoreError
            If it is neither.

        """
        kinds = [field.name for field in fields(cls)]
        ages: dict[str, float] = {}
        for part in text.replace(' ', '').split(',') if text.strip() else ():
            kind, _, age = part.rpartition('=')
            found = _AGE.fullmatch(age)
            if found is None or (kind and kind not in kinds):
                raise StoreError(
                    f'{part!r} is no age to keep, expected 30d, or {"=30d, ".join(kinds)}=30d'
                )
            seconds = float(found[1]) * _UNITS[found[2]]
            ages |= dict.fromkeys([kind] if kind else kinds, seconds)
        return cls(**ages)


def forget_old(database: Database, keep: Keep, now_ns: int) -> dict[str, int]:
    """
    Delete what is older than it is to be kept; return how much of each kind that was.

    Positions go by whole spans of 2 s. A run of which nothing is left goes, too.

    Parameters
    ----------
    database : Database
        In which.
    keep : Keep
        How long.
    now_ns : int
        What time it is, ns.

    Raises
    ------
    StoreError
        If the database refuses.

    """
    before = {
        field.name: now_ns - round(age * 1e9)
        for field in fields(keep)
        if (age := getattr(keep, field.name)) is not None
    }
    found = dict.fromkeys(before, 0)
    if 'positions' in before:
        found['positions'] = _forget_positions(database, before['positions'])
    with database.alone() as connection:
        if 'events' in before:
            old = EVENT_MESSAGES.c.stamp_ns < before['events']
            connection.execute(delete(EVENTS).where(EVENTS.c.stamp_ns < before['events']))
            found['events'] = connection.execute(delete(EVENT_MESSAGES).where(old)).rowcount
        if 'corrections' in before:
            found['corrections'] = _forget_corrections(connection, before['corrections'])
        if 'videos' in before:
            old = VIDEOS.c.ended_ns < before['videos']
            found['videos'] = connection.execute(delete(VIDEOS).where(old)).rowcount
        if 'positions' in before:
            _forget_empty_runs(connection, before['positions'])
    return found


def forget_run(connection: Connection, run: int) -> None:
    """Delete a run by its number, with all that belongs to it."""
    chunks = connection.execute(select(CHUNKS.c.chunk_id).where(CHUNKS.c.run_id == run))
    forget_chunks(connection, list(chunks.scalars()))
    for table in (*_OF_RUN, RUNS):
        connection.execute(delete(table).where(table.c.run_id == run))


def forget_chunks(connection: Connection, chunks: Sequence[int]) -> None:
    """Delete chunks by their numbers, with their second blobs and boxes."""
    delete_boxes(connection, chunks)
    for table in (RESTS, CHUNKS):
        for start in range(0, len(chunks), 500):
            part = chunks[start : start + 500]
            connection.execute(delete(table).where(table.c.chunk_id.in_(part)))


def _forget_positions(database: Database, before_ns: int) -> int:
    """Delete the spans that end before an instant; return how many rows they had."""
    with database.connected() as connection:
        asked = select(RUNS.c.run_id, RUNS.c.began_ns).where(RUNS.c.began_ns.is_not(None))
        runs = [Stored(*row) for row in connection.execute(asked).all()]
    rows = 0
    for stored in runs:
        last = min((before_ns - stored.began_ns) // SPAN_NS, 2**31 - 1)
        while last > 0:
            with database.alone() as connection:
                first = _first_span(connection, stored)
                if first is None or first >= last:
                    break
                rows += _forget_spans(connection, stored, min(first + _SPANS, last))
    return rows


def _first_span(connection: Connection, stored: Stored) -> int | None:
    found = [
        connection.execute(
            select(func.min(table.c.span)).where(table.c.run_id == stored.run)
        ).scalar()
        for table in (TICKS, JOURNAL)
    ]
    return min((each for each in found if each is not None), default=None)


def _forget_spans(connection: Connection, stored: Stored, last: int) -> int:
    """Delete the spans before one, and what the table of tracks counts of them."""
    of_run = (CHUNKS.c.run_id == stored.run) & (CHUNKS.c.span < last)
    asked = select(CHUNKS.c.chunk_id, CHUNKS.c.track_id, CHUNKS.c.places).where(of_run)
    chunks = connection.execute(asked).all()
    _, counts = blocks.unpack_all([row.places for row in chunks], blocks.PLACES_WIDTH)
    gone = Counter[int]()
    for row, count in zip(chunks, counts.tolist()):
        gone[row.track_id] += count
    for block in load_journal(connection, stored):
        if stored.span(block.began_ns) < last:
            gone.update(block.words[:, blocks.ID].tolist())
    forget_chunks(connection, [row.chunk_id for row in chunks])
    for table in (TICKS, JOURNAL):
        of_run = (table.c.run_id == stored.run) & (table.c.span < last)
        connection.execute(delete(table).where(of_run))
    for track, count in gone.items():
        _take_off(connection, stored, track, count)
    until_ns = stored.span_ns(last)
    for table in (MEMBERS, GROUPS):
        old = (table.c.run_id == stored.run) & (table.c.ended_ns < until_ns)
        connection.execute(delete(table).where(old))
    return gone.total()


def _take_off(connection: Connection, stored: Stored, track: int, count: int) -> None:
    """Let the table of tracks count so many rows of a track less."""
    of_track = (TRACKS.c.run_id == stored.run) & (TRACKS.c.track_id == track)
    began_ns = _first_stamp(connection, stored, track)
    if began_ns is None:
        connection.execute(delete(TRACKS).where(of_track))
        return
    values: dict[str, Any] = {'began_ns': began_ns, 'positions': TRACKS.c.positions - count}
    connection.execute(update(TRACKS).where(of_track).values(values))


def _first_stamp(connection: Connection, stored: Stored, track: int) -> int | None:
    """Return the first stamp of a track that is left, ns."""
    asked = select(func.min(CHUNKS.c.span)).where(
        CHUNKS.c.run_id == stored.run, CHUNKS.c.track_id == track
    )
    span = connection.execute(asked).scalar()
    if span is None:
        rows = load_rows(connection, stored, (0, 2**63 - 1), tracks=[track], chunks=[])
    else:
        between = stored.span_ns(span), stored.span_ns(span + 1)
        rows = load_rows(connection, stored, between, tracks=[track])
    return int(rows.stamp_ns[0]) if len(rows) else None


def _forget_corrections(connection: Connection, before_ns: int) -> int:
    """Delete corrections before an instant, also as events; return how many."""
    old = CORRECTIONS.c.stamp_ns < before_ns
    count = connection.execute(delete(CORRECTIONS).where(old)).rowcount
    connection.execute(
        delete(EVENTS).where(
            EVENTS.c.event == int(EventCode.CORRECTION),
            EVENTS.c.topic == EVENTS_TOPIC,
            EVENTS.c.stamp_ns < before_ns,
        )
    )
    same = (EVENTS.c.run_id == EVENT_MESSAGES.c.run_id) & (
        EVENTS.c.number == EVENT_MESSAGES.c.number
    )
    connection.execute(
        delete(EVENT_MESSAGES).where(EVENT_MESSAGES.c.stamp_ns < before_ns, ~exists().where(same))
    )
    return count


def _forget_empty_runs(connection: Connection, before_ns: int) -> None:
    """Delete runs that began before an instant and of which nothing is left."""
    tables = (TICKS, JOURNAL, EVENT_MESSAGES, CORRECTIONS)
    empty = select(RUNS.c.run_id).where(
        RUNS.c.began_ns < before_ns,
        *(~exists().where(table.c.run_id == RUNS.c.run_id) for table in tables),
    )
    for run in connection.execute(empty).scalars().all():
        forget_run(connection, run)
