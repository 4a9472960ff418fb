"""The first tables."""

from __future__ import annotations

from alembic import op
from sqlalchemy import (
    BigInteger,
    Column,
    Float,
    ForeignKey,
    Integer,
    LargeBinary,
    String,
    Text,
    UniqueConstraint,
)

from mctrack_ros.store.boxes import INDICES

revision = '0001'
down_revision = None

_KEY = BigInteger().with_variant(Integer, 'sqlite')


def _run() -> Column[int]:
    return Column('run_id', Integer, ForeignKey('runs.run_id'), primary_key=True)


def upgrade() -> None:
    """Make the tables, and the index of boxes that the back end has."""
    op.create_table(
        'sites',
        Column('site_id', Integer, primary_key=True),
        Column('name', String(200), nullable=False, unique=True),
    )
    op.create_table(
        'cameras',
        Column('camera_id', Integer, primary_key=True),
        Column('site_id', Integer, ForeignKey('sites.site_id'), nullable=False),
        Column('name', String(200), nullable=False),
        UniqueConstraint('site_id', 'name'),
    )
    op.create_table(
        'runs',
        Column('run_id', Integer, primary_key=True),
        Column('site_id', Integer, ForeignKey('sites.site_id'), nullable=False),
        Column('name', String(200), nullable=False, unique=True),
        Column('frame_id', String(200), nullable=False),
        Column('began_ns', BigInteger),
        Column('ended_ns', BigInteger),
    )
    op.create_table(
        'run_cameras',
        _run(),
        Column('bit', Integer, primary_key=True),
        Column('camera_id', Integer, ForeignKey('cameras.camera_id'), nullable=False),
    )
    op.create_table(
        'descriptions',
        _run(),
        Column('number', Integer, primary_key=True),
        Column('log_ns', BigInteger, nullable=False),
        Column('text', Text, nullable=False),
    )
    _create_tracks()
    _create_events()
    for statement in INDICES[op.get_bind().dialect.name].CREATE:
        op.execute(statement)


def _create_tracks() -> None:
    op.create_table(
        'tracks',
        _run(),
        Column('track_id', BigInteger, primary_key=True),
        Column('began_ns', BigInteger, nullable=False),
        Column('ended_ns', BigInteger, nullable=False),
        Column('positions', BigInteger, nullable=False),
        Column('class_id', Integer, nullable=False),
    )
    op.create_table(
        'chunks',
        Column('chunk_id', _KEY, primary_key=True, autoincrement=False),
        Column('run_id', Integer, ForeignKey('runs.run_id'), nullable=False),
        Column('span', Integer, nullable=False),
        Column('track_id', BigInteger, nullable=False),
        Column('places', LargeBinary, nullable=False),
    )
    op.create_index('chunks_of_track', 'chunks', ['run_id', 'track_id', 'span'])
    op.create_index('chunks_of_span', 'chunks', ['run_id', 'span'])
    op.create_table(
        'rests',
        Column('chunk_id', _KEY, primary_key=True, autoincrement=False),
        Column('rest', LargeBinary, nullable=False),
    )
    op.create_table(
        'ticks',
        _run(),
        Column('span', Integer, primary_key=True),
        Column('ticks', LargeBinary, nullable=False),
    )
    op.create_table(
        'journal',
        _run(),
        Column('number', Integer, primary_key=True),
        Column('span', Integer, nullable=False),
        Column('ticks', LargeBinary, nullable=False),
        Column('words', LargeBinary, nullable=False),
    )
    op.create_table(
        'groups',
        _run(),
        Column('group_id', BigInteger, primary_key=True),
        Column('began_ns', BigInteger, nullable=False),
        Column('ended_ns', BigInteger, nullable=False),
    )
    op.create_table(
        'group_members',
        _run(),
        Column('group_id', BigInteger, primary_key=True),
        Column('track_id', BigInteger, primary_key=True),
        Column('began_ns', BigInteger, primary_key=True),
        Column('ended_ns', BigInteger, nullable=False),
    )


def _create_events() -> None:
    op.create_table(
        'event_messages',
        _run(),
        Column('number', Integer, primary_key=True),
        Column('topic', String(200), nullable=False),
        Column('stamp_ns', BigInteger, nullable=False),
        Column('log_ns', BigInteger, nullable=False),
    )
    op.create_table(
        'events',
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
    )
    op.create_index('events_of_run', 'events', ['run_id', 'stamp_ns'])
    op.create_table(
        'corrections',
        _run(),
        Column('number', Integer, primary_key=True),
        Column('line', Integer, primary_key=True),
        Column('stamp_ns', BigInteger, nullable=False),
        Column('since_ns', BigInteger, nullable=False),
        Column('old_id', BigInteger, nullable=False),
        Column('new_id', BigInteger, nullable=False),
        Column('probability', Float, nullable=False),
    )
    op.create_table(
        'videos',
        Column('video_id', Integer, primary_key=True),
        Column('camera_id', Integer, ForeignKey('cameras.camera_id'), nullable=False),
        Column('path', Text, nullable=False),
        Column('began_ns', BigInteger, nullable=False),
        Column('ended_ns', BigInteger, nullable=False),
    )


def downgrade() -> None:
    """Remove the tables."""
    for statement in INDICES[op.get_bind().dialect.name].DROP:
        op.execute(statement)
    events = ('videos', 'corrections', 'events', 'event_messages')
    tracks = ('group_members', 'groups', 'journal', 'ticks', 'rests', 'chunks', 'tracks')
    for name in (*events, *tracks, 'descriptions', 'run_cameras', 'runs', 'cameras', 'sites'):
        op.drop_table(name)
