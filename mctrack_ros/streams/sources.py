"""Frames of a bag, and of a run of a trajectory database."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from sqlalchemy import Connection, select

from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.interfaces import Events, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.recording.closing import Closing
from mctrack_ros.store import Database, run_of_bag
from mctrack_ros.store.rows import Stored, load_journal, load_spans
from mctrack_ros.store.runs import find_run
from mctrack_ros.store.schema import DESCRIPTIONS, EVENTS
from mctrack_ros.store.writer import EVENTS_TOPIC, events_of
from mctrack_ros.streams.frames import About, Assembler, Frame

_TRACKS_TOPIC = '/tracks'
_SPANS = 5
"""Spans of a run that are read at once: ten seconds."""
_LATEST_NS = 2**63 - 1  # what a column of 64 bits holds


def about_bag(bag: str | Path) -> About:
    """
    Return what a bag says of its run.

    Raises
    ------
    BagError
        If it cannot be read or has no `/tracks`.

    """
    run = run_of_bag(bag)
    with BagReader(bag) as reader:
        for _, message, _ in reader.messages([SITE_TOPIC]) if reader.count(SITE_TOPIC) else ():
            return About.of_site(message.data, run.frame_id, run.name)
    return About(run.name, run.frame_id)


def bag_frames(bag: str | Path, about: About) -> Iterator[Frame]:
    """
    Yield the frames of a bag.

    Raises
    ------
    BagError
        If it cannot be read.

    """
    assembler = Assembler(about)
    with BagReader(bag) as reader:
        topics = [topic for topic in (_TRACKS_TOPIC, EVENTS_TOPIC) if reader.count(topic)]
        for topic, message, _ in reader.messages(topics):
            if topic == EVENTS_TOPIC:
                assembler.add_events(rows_from_cloud(message, Events))
            elif frame := assembler.add_tracks(rows_from_cloud(message, Tracks)):
                yield frame
        if frame := assembler.finish():
            yield frame


def about_run(database: Database, name: str = '') -> About:
    """
    Return what a database says of a run: of the only one unless it is named.

    Raises
    ------
    StoreError
        If there is no such run.

    """
    with database.connected() as connection:
        run = find_run(connection, name)
        asked = select(DESCRIPTIONS.c.text).where(DESCRIPTIONS.c.run_id == run.run_id)
        said = connection.execute(asked.order_by(DESCRIPTIONS.c.number)).scalars().first()
    return About.of_site(said, run.frame_id, run.name) if said else About(run.name, run.frame_id)


class Connectable(Protocol):
    """A database, or what opens one."""

    def connected(self) -> AbstractContextManager[Connection]:
        """Return a connection, for a ``with`` statement."""
        ...


class Archive(Closing):
    """
    A database that is opened when it is first asked: it may be made later.

    Parameters
    ----------
    place : str
        A file, or a URL.

    """

    def __init__(self, place: str) -> None:
        self._place, self._lock = place, threading.Lock()
        self._database: Database | None = None

    def connected(self) -> AbstractContextManager[Connection]:
        """Return a connection; raises `StoreError`."""
        with self._lock:
            self._database = self._database or Database(self._place)
        return self._database.connected()

    def close(self) -> None:
        """Close its connections."""
        if self._database is not None:
            self._database.close()


class RunFrames:
    """
    Frames of a run of a database, some seconds at a time: what was said at the time, uncorrected.

    Parameters
    ----------
    database : Connectable
        Where it is.
    about : About
        The run.
    after_ns : int
        A stamp before the frames that are wanted, ns.

    """

    def __init__(self, database: Connectable, about: About, after_ns: int = 0) -> None:
        self._database, self._run = database, about.run
        self._assembler = Assembler(about)
        self._begin_ns = after_ns - about.lost_ns  # who was lost before may be forgotten now
        self._span: int | None = None
        self._last_ns = -1
        self._ahead: list[Frame] = []

    def next(self, after_ns: int = -1, before_ns: int = _LATEST_NS) -> Sequence[Frame]:
        """
        Return the next frames after a stamp and before another, ns; empty: no more for now.

        Raises
        ------
        StoreError
            If the database refuses, or there is no such run.

        """
        with self._database.connected() as connection:
            run = find_run(connection, self._run)
            if run.began_ns is None:
                return ()
            stored = Stored(run.run_id, run.began_ns)
            while not self._ahead:
                fresh = self._messages(connection, stored)
                if not fresh:
                    break
                frames = self._frames(connection, stored, fresh)
                self._ahead = [frame for frame in frames if frame.stamp_ns > after_ns]
        wanted = [frame for frame in self._ahead if after_ns < frame.stamp_ns < before_ns]
        self._ahead = [frame for frame in self._ahead if frame.stamp_ns >= before_ns]
        return wanted

    def __iter__(self) -> Iterator[Frame]:
        """Yield all that there are."""
        while frames := self.next():
            yield from frames

    def _messages(self, connection: Connection, stored: Stored) -> list[Tracks]:
        """Return the next messages of `/tracks`."""
        if self._span is None:
            self._span = max(stored.span(self._begin_ns) - 1, 0)
        blocks = list(load_spans(connection, stored, self._span, _SPANS))
        if blocks:
            self._span = stored.span(blocks[-1].began_ns) + 1
        else:
            blocks = list(load_journal(connection, stored))
        messages = [rows for block in blocks for rows, _ in block.messages()]
        return [rows for rows in messages if rows.stamp_ns > self._last_ns]

    def _frames(
        self, connection: Connection, stored: Stored, messages: Sequence[Tracks]
    ) -> list[Frame]:
        """Return the frames of messages."""
        last_ns = messages[-1].stamp_ns
        if self._last_ns < 0:
            self._last_ns = messages[0].stamp_ns - 1
        events = self._events(connection, stored, last_ns)
        frames = []
        for rows in messages:
            self._assembler.add_tracks(rows)
            while events and events[0].stamp_ns <= rows.stamp_ns:
                self._assembler.add_events(events.pop(0))
            frame = self._assembler.finish()
            assert frame is not None
            frames.append(frame)
        self._last_ns = last_ns
        return frames

    def _events(self, connection: Connection, stored: Stored, last_ns: int) -> list[Events]:
        """Return the messages of events since those before, up to a stamp, ns."""
        asked = select(EVENTS.c.number, EVENTS.c.stamp_ns, EVENTS.c.row).where(
            EVENTS.c.run_id == stored.run,
            EVENTS.c.topic == EVENTS_TOPIC,
            EVENTS.c.stamp_ns > self._last_ns,
            EVENTS.c.stamp_ns <= last_ns,
        )
        ordered = asked.order_by(EVENTS.c.stamp_ns, EVENTS.c.number, EVENTS.c.line)
        rows: dict[tuple[int, int], list[bytes]] = {}
        for number, stamp_ns, row in connection.execute(ordered).all():
            rows.setdefault((stamp_ns, number), []).append(row)
        return [events_of(stamp_ns, each) for (stamp_ns, _), each in rows.items()]
