"""Bags into a trajectory database and back."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator
from heapq import merge
from operator import itemgetter
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, select

from mctrack_ros.codec import further_fields, rows_from_cloud
from mctrack_ros.interfaces import Events, Tracks
from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import LeftOutWarning
from mctrack_ros.store.rows import Stored, load_blocks
from mctrack_ros.store.runs import NewRun, find_run
from mctrack_ros.store.schema import DESCRIPTIONS, EVENT_MESSAGES, EVENTS
from mctrack_ros.store.writer import TrajectoryWriter, events_of

TRACKS_TOPIC = '/tracks'
_CLOUD = 'sensor_msgs/msg/PointCloud2'


def run_of_bag(bag: str | Path, name: str = '', site: str = 'site') -> NewRun:
    """
    Return the run that a bag holds: by default named as `/site` says, or as the bag.

    Raises
    ------
    BagError
        If the bag cannot be read or has no `/tracks`.

    """
    said: dict[str, Any] = {}
    with BagReader(bag) as reader:
        if not reader.count(TRACKS_TOPIC):
            raise BagError(f'{bag} has no {TRACKS_TOPIC}: mctrack track makes them')
        _, first, _ = next(reader.messages([TRACKS_TOPIC]))
        for _, message, _ in reader.messages([SITE_TOPIC]) if reader.count(SITE_TOPIC) else ():
            try:
                said = dict(json.loads(message.data))
            except ValueError as error:
                raise BagError(f'{bag}: {SITE_TOPIC} holds no JSON: {error}') from error
            break
    named = name or str(said.get('run') or Path(bag).resolve().name)
    cameras = tuple(map(str, said.get('cameras') or ()))
    return NewRun(named, site, cameras, first.header.frame_id)


def store_bag(
    bag: str | Path,
    database: Database,
    *,
    run: NewRun | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> NewRun:
    """
    Write the tracks, events and corrections of a bag into a database.

    Parameters
    ----------
    bag : str or Path
        With `/tracks`, and `/events` of fusion and of cameras if there are any.
    database : Database
        Where they go.
    run : NewRun, optional
        What the run is; unless given, what the bag says (`run_of_bag`).
    progress : callable
        Called with messages done and in all.

    Warns
    -----
    LeftOutWarning
        If messages have fields that the database does not keep.

    Raises
    ------
    BagError
        If the bag cannot be read or has no `/tracks`.
    StoreError
        If the run is there already, or its time steps back.

    """
    with BagReader(bag) as reader:
        topics = [topic for topic, kind in reader.topics.items() if _is_stored(topic, kind)]
        total, new = sum(map(reader.count, topics)), run or run_of_bag(bag)
        looked_at: set[str] = set()
        with TrajectoryWriter(database, new) as writer:
            for done, (topic, message, log_ns) in enumerate(reader.messages(topics), 1):
                if topic != SITE_TOPIC and message.header.frame_id != new.frame_id:
                    raise BagError(
                        f'{bag}: {topic} is in the frame {message.header.frame_id}, '
                        f'the tracks are in {new.frame_id}'
                    )
                if topic not in looked_at:
                    looked_at.add(topic)
                    _warn_of_further(message, topic)
                if topic == SITE_TOPIC:
                    writer.write_description(message.data, log_ns)
                elif topic == TRACKS_TOPIC:
                    writer.write_tracks(rows_from_cloud(message, Tracks), log_ns)
                else:
                    writer.write_events(rows_from_cloud(message, Events), topic, log_ns)
                progress(done, total)
    return new


def write_bag(
    database: Database, bag: str | Path, *, run: str = '', overwrite: bool = False
) -> int:
    """
    Write a run of a database as a bag; return how many messages it has.

    The messages and log times of each topic are those of the bag that the run was stored from.

    Parameters
    ----------
    database : Database
        With the run.
    bag : str or Path
        The folder to write.
    run : str
        The run; it need not be named if there is only one.
    overwrite : bool
        Whether a bag already there is replaced.

    Raises
    ------
    BagError
        If the bag cannot be written.
    StoreError
        If there is no such run.

    """
    count = 0
    with database.connected() as connection, BagWriter(bag, overwrite=overwrite) as writer:
        found = find_run(connection, run)
        stored = Stored(found.run_id, found.began_ns or 0)
        sources = (_descriptions, _tracks, _events)
        streams: list[Iterator[tuple[int, str, Any]]]
        streams = [source(connection, stored) for source in sources]
        for log_ns, topic, message in merge(*streams, key=itemgetter(0)):
            if isinstance(message, str):
                writer.write_text(topic, message, log_ns)
            else:
                writer.write_rows(topic, message, found.frame_id, log_ns)
            count += 1
    return count


def kind_of(topic: str) -> type[Tracks | Events]:
    """Return what a topic of clouds holds, of those that are kept."""
    return Tracks if topic == TRACKS_TOPIC else Events


def _warn_of_further(message: Any, topic: str) -> None:
    if topic != SITE_TOPIC and (further := further_fields(message, kind_of(topic))):
        warnings.warn(f'{topic}: not stored: {", ".join(further)}', LeftOutWarning, stacklevel=3)


def _is_stored(topic: str, kind: str) -> bool:
    is_events = topic.endswith('/events') and kind == _CLOUD
    return topic in {TRACKS_TOPIC, SITE_TOPIC} or is_events


def _descriptions(connection: Connection, stored: Stored) -> Iterator[tuple[int, str, str]]:
    asked = select(DESCRIPTIONS).where(DESCRIPTIONS.c.run_id == stored.run)
    for row in connection.execute(asked.order_by(DESCRIPTIONS.c.number)).all():
        yield row.log_ns, SITE_TOPIC, row.text


def _tracks(connection: Connection, stored: Stored) -> Iterator[tuple[int, str, Tracks]]:
    for block in load_blocks(connection, stored):
        for tracks, log_ns in block.messages():
            yield log_ns, TRACKS_TOPIC, tracks


def _events(connection: Connection, stored: Stored) -> Iterator[tuple[int, str, Events]]:
    rows: dict[int, list[bytes]] = {}
    asked = select(EVENTS.c.number, EVENTS.c.row).where(EVENTS.c.run_id == stored.run)
    for number, row in connection.execute(asked.order_by(EVENTS.c.number, EVENTS.c.line)):
        rows.setdefault(number, []).append(row)
    asked_messages = select(EVENT_MESSAGES).where(EVENT_MESSAGES.c.run_id == stored.run)
    for each in connection.execute(asked_messages.order_by(EVENT_MESSAGES.c.number)).all():
        yield each.log_ns, each.topic, events_of(each.stamp_ns, rows.get(each.number, []))
