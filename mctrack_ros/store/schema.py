"""Tables of the trajectory database, the same for all back ends."""

from __future__ import annotations

from typing import Any

from sqlalchemy import (
    BigInteger,
    Column,
    Connection,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.dialects import postgresql, sqlite

METADATA = MetaData()
_KEY = BigInteger().with_variant(Integer, 'sqlite')
"""SQLite finds rows by whole numbers called INTEGER without an index; they have 64 bits."""


def _run() -> Column[int]:
    return Column('run_id', Integer, ForeignKey('runs.run_id'), primary_key=True)


SITES = Table(
    'sites',
    METADATA,
    Column('site_id', Integer, primary_key=True),
    Column('name', String(200), nullable=False, unique=True),
)
CAMERAS = Table(
    'cameras',
    METADATA,
    Column('camera_id', Integer, primary_key=True),
    Column('site_id', Integer, ForeignKey('sites.site_id'), nullable=False),
    Column('name', String(200), nullable=False),
    UniqueConstraint('site_id', 'name'),
)
RUNS = Table(
    'runs',
    METADATA,
    Column('run_id', Integer, primary_key=True),
    Column('site_id', Integer, ForeignKey('sites.site_id'), nullable=False),
    Column('name', String(200), nullable=False, unique=True),
    Column('frame_id', String(200), nullable=False),
    Column('began_ns', BigInteger),
    Column('ended_ns', BigInteger),
)
"""A run of the tracker; ``began_ns`` is the stamp of its first tick, ``ended_ns`` of its last, set
when the run is finished."""
RUN_CAMERAS = Table(
    'run_cameras',
    METADATA,
    _run(),
    Column('bit', Integer, primary_key=True),
    Column('camera_id', Integer, ForeignKey('cameras.camera_id'), nullable=False),
)
"""Which bit of ``cameras`` is which camera."""
DESCRIPTIONS = Table(
    'descriptions',
    METADATA,
    _run(),
    Column('number', Integer, primary_key=True),
    Column('log_ns', BigInteger, nullable=False),
    Column('text', Text, nullable=False),
)
"""What `/site` said."""
TRACKS = Table(
    'tracks',
    METADATA,
    _run(),
    Column('track_id', BigInteger, primary_key=True),
    Column('began_ns', BigInteger, nullable=False),
    Column('ended_ns', BigInteger, nullable=False),
    Column('positions', BigInteger, nullable=False),
    Column('class_id', Integer, nullable=False),
)
CHUNKS = Table(
    'chunks',
    METADATA,
    Column('chunk_id', _KEY, primary_key=True, autoincrement=False),
    Column('run_id', Integer, ForeignKey('runs.run_id'), nullable=False),
    Column('span', Integer, nullable=False),
    Column('track_id', BigInteger, nullable=False),
    Column('places', LargeBinary, nullable=False),
    Index('chunks_of_track', 'run_id', 'track_id', 'span'),
    Index('chunks_of_span', 'run_id', 'span'),
)
"""A track in one span of the run: 2 s. Its box lies in the index of `boxes`."""
RESTS = Table(
    'rests',
    METADATA,
    Column('chunk_id', _KEY, primary_key=True, autoincrement=False),
    Column('rest', LargeBinary, nullable=False),
)
"""The other columns of a chunk, apart: what asks for places does not read them."""
TICKS = Table(
    'ticks',
    METADATA,
    _run(),
    Column('span', Integer, primary_key=True),
    Column('ticks', LargeBinary, nullable=False),
)
"""Stamps, log times and row counts of the messages in a span."""
JOURNAL = Table(
    'journal',
    METADATA,
    _run(),
    Column('number', Integer, primary_key=True),
    Column('span', Integer, nullable=False),
    Column('ticks', LargeBinary, nullable=False),
    Column('words', LargeBinary, nullable=False),
)
"""Messages of the span that is not yet complete."""
GROUPS = Table(
    'groups',
    METADATA,
    _run(),
    Column('group_id', BigInteger, primary_key=True),
    Column('began_ns', BigInteger, nullable=False),
    Column('ended_ns', BigInteger, nullable=False),
)
MEMBERS = Table(
    'group_members',
    METADATA,
    _run(),
    Column('group_id', BigInteger, primary_key=True),
    Column('track_id', BigInteger, primary_key=True),
    Column('began_ns', BigInteger, primary_key=True),
    Column('ended_ns', BigInteger, nullable=False),
)
"""Membership of a group, from when to when."""
EVENT_MESSAGES = Table(
    'event_messages',
    METADATA,
    _run(),
    Column('number', Integer, primary_key=True),
    Column('topic', String(200), nullable=False),
    Column('stamp_ns', BigInteger, nullable=False),
    Column('log_ns', BigInteger, nullable=False),
)
EVENTS = Table(
    'events',
    METADATA,
    _run(),
    Column('number', Integer, primary_key=True),
    Column('line', Integer, primary_key=True),
    Column('topic', String(200), nullable=False),
    Column('stamp_ns', BigInteger, nullable=False),
    Column('event', Integer, nullable=False),
    Column('track_id', BigInteger, nullable=False),
    Column('x', Float),
    Column('y', Float),
    Column('row', LargeBinary, nullable=False),
    Index('events_of_run', 'run_id', 'stamp_ns'),
)
"""An event; ``row`` holds all its columns as they travel."""
CORRECTIONS = Table(
    'corrections',
    METADATA,
    _run(),
    Column('number', Integer, primary_key=True),
    Column('line', Integer, primary_key=True),
    Column('stamp_ns', BigInteger, nullable=False),
    Column('since_ns', BigInteger, nullable=False),
    Column('old_id', BigInteger, nullable=False),
    Column('new_id', BigInteger, nullable=False),
    Column('probability', Float, nullable=False),
)
"""``old_id`` is ``new_id`` from ``stamp_ns`` on, and was from ``since_ns`` on."""
PROGRESS = Table(
    'progress',
    METADATA,
    Column('source', String(200), primary_key=True),
    Column('position', BigInteger, nullable=False),
    Column('run_id', Integer, nullable=False),
)
"""How far the messages of a source are written, and into which run the last one."""
VIDEOS = Table(
    'videos',
    METADATA,
    Column('video_id', Integer, primary_key=True),
    Column('camera_id', Integer, ForeignKey('cameras.camera_id'), nullable=False),
    Column('path', Text, nullable=False),
    Column('began_ns', BigInteger, nullable=False),
    Column('ended_ns', BigInteger, nullable=False),
)


def upsert(connection: Connection, table: Table) -> Any:
    """Return an insertion that may say what happens to rows that are there."""
    dialect = sqlite if connection.dialect.name == 'sqlite' else postgresql
    return dialect.insert(table)
