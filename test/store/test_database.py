"""What is written is read again, in both back ends."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES, BagReader, BagWriter
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.store import (
    Database,
    NewRun,
    Run,
    StoreError,
    TrajectoryWriter,
    store_bag,
    write_bag,
)
from mctrack_ros.store.blocks import pack, unpack
from mctrack_ros.store.errors import LeftOutWarning
from mctrack_ros.store.rows import load_blocks
from mctrack_ros.store.schema import METADATA

BEGAN_NS = 1_700_000_000_000_000_000
TICK_NS = 40_000_000
ROOT = Path(__file__).resolve().parents[2]


def assert_same(one, other):
    assert one.stamp_ns == other.stamp_ns
    for name in Tracks.COLUMNS:
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name


def messages_of(database, run):
    with Run(database, run) as opened, database.connected() as connection:
        stored = opened.stored
        return [each for block in load_blocks(connection, stored) for each in block.messages()]


@st.composite
def messages(draw):
    """Draw messages of any numbers: NaN, no rows, ids that come again, two rows of an id."""
    stamp_ns, found = BEGAN_NS, []
    for _ in range(draw(st.integers(1, 8))):
        stamp_ns += draw(st.sampled_from([1, TICK_NS, 700_000_000, 5_000_000_000]))
        count = draw(st.integers(0, 3))
        columns = {
            name: draw(st_numpy.arrays(column.dtype, (count, *column.shape)))
            for name, column in Tracks.COLUMNS.items()
            if name != 'track_id'
        }
        upper = np.triu(np.ones((4, 4), bool))
        square = columns['covariance']
        columns['covariance'] = np.where(upper, square, square.swapaxes(1, 2))
        ids = draw(st.lists(st.sampled_from([1, 2, 2**32 - 1]), min_size=count, max_size=count))
        rows = Tracks.build(stamp_ns, track_id=ids, **columns)
        found.append((rows, stamp_ns + draw(st.integers(0, 10**6))))
    return found


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(sent=messages())
def test_messages_come_back_bit_by_bit(database, sent):
    run = str(uuid4())
    with TrajectoryWriter(database, NewRun(run)) as writer:
        for rows, log_ns in sent:
            writer.write_tracks(rows, log_ns)
    found = messages_of(database, run)
    assert [log_ns for _, log_ns in found] == [log_ns for _, log_ns in sent]
    for (one, _), (other, _) in zip(found, sent):
        assert_same(one, other)


@given(st_numpy.arrays(np.uint32, st.tuples(st.integers(1, 40), st.integers(1, 7))))
def test_numbers_come_back_from_a_blob(words):
    assert np.array_equal(unpack(pack(words), words.shape[1]), words)


def people(stamp_ns, places, **columns):
    position = [(x, y, 0.0) for x, y in places.values()]
    return Tracks.build(stamp_ns, track_id=list(places), position=position, **columns)


def test_time_that_steps_back_is_refused(database):
    with TrajectoryWriter(database, NewRun('a')) as writer:
        writer.write_tracks(people(BEGAN_NS, {1: (0, 0)}))
        for stamp_ns in (BEGAN_NS, BEGAN_NS - 1):
            with pytest.raises(StoreError, match=f'steps back from {BEGAN_NS} to {stamp_ns}'):
                writer.write_tracks(people(stamp_ns, {1: (0, 0)}))
    assert len(messages_of(database, 'a')) == 1


def test_a_run_is_written_once(database):
    with TrajectoryWriter(database, NewRun('a')):
        pass
    with pytest.raises(StoreError, match='run a is in the database already'):
        TrajectoryWriter(database, NewRun('a'))


def test_a_writer_that_was_left_is_continued(database):
    """Half a second at most is lost, and the span that was open goes on."""
    seconds = [0.0]
    sent = [people(BEGAN_NS + k * TICK_NS, {1: (k * 0.1, 0), 2: (0, k)}) for k in range(130)]
    writer = TrajectoryWriter(database, NewRun('a'), clock=lambda: seconds[0])
    for k, rows in enumerate(sent[:70]):
        seconds[0] = k * 0.04
        writer.write_tracks(rows)
    kept = len(messages_of(database, 'a'))
    assert 70 - 13 <= kept < 70
    with TrajectoryWriter(database, NewRun('a'), resume=True) as again:
        for rows in sent[kept:]:
            again.write_tracks(rows)
    found = messages_of(database, 'a')
    assert len(found) == len(sent)
    for (one, _), other in zip(found, sent):
        assert_same(one, other)
    with pytest.raises(StoreError, match='is finished'):
        TrajectoryWriter(database, NewRun('a'), resume=True)


KILLED = """
import sys, time
from mctrack_ros.store import Database, NewRun, TrajectoryWriter
from mctrack_ros.interfaces import Tracks
writer = TrajectoryWriter(Database(sys.argv[1], create=True), NewRun('a'))
stamp = 1_700_000_000_000_000_000
while True:
    stamp += 40_000_000
    writer.write_tracks(Tracks.build(stamp, track_id=[1, 2], position=[[1, 2, 0], [3, 4, 0]]))
    print(stamp, time.monotonic_ns(), flush=True)
    time.sleep(0.002)
"""


@pytest.mark.parametrize('after', [400, 700, 1100])
def test_a_killed_writer_loses_half_a_second_at_most(place, after):
    Database(place, create=True).close()
    path = f'{ROOT}{os.pathsep}{os.environ.get("PYTHONPATH", "")}'
    process = subprocess.Popen(
        [sys.executable, '-c', KILLED, place],
        stdout=subprocess.PIPE,
        env={**os.environ, 'PYTHONPATH': path},
    )
    lines = [process.stdout.readline() for _ in range(after)]
    process.send_signal(signal.SIGKILL)
    lines += process.stdout.readlines()
    process.wait()
    told = [tuple(map(int, line.split())) for line in lines if line.endswith(b'\n')]
    with Database(place) as database:
        found = [rows.stamp_ns for rows, _ in messages_of(database, 'a')]
    assert found == [stamp_ns for stamp_ns, _ in told[: len(found)]] or len(found) > len(told)
    written_ns = dict(told)
    assert told[-1][1] - written_ns.get(found[-1], told[-1][1]) <= 0.6e9


def test_a_database_that_is_none_is_refused(tmp_path):
    with pytest.raises(StoreError, match='there is no database'):
        Database(tmp_path / 'none.db')
    (tmp_path / 'text.db').write_text('no database at all, but a text of some length' * 9)
    with pytest.raises(StoreError, match='not a database'):
        Database(tmp_path / 'text.db')
    with pytest.raises(StoreError, match='mysql is not known'):
        Database('mysql://localhost/tracks')


def test_no_error_shows_a_password():
    with pytest.raises(StoreError) as raised:
        Database('postgresql://somebody:secret@/tracks?host=/nowhere')
    assert 'secret' not in str(raised.value)


def test_migrations_make_the_tables_of_the_schema(database):
    with database.connected() as connection:
        context = MigrationContext.configure(
            connection, opts={'include_name': lambda name, kind, _: _is_ours(name, kind)}
        )
        assert compare_metadata(context, METADATA) == []


def _is_ours(name, kind):
    return kind != 'table' or name in METADATA.tables


def log_of(bag):
    """Return messages and log times by topic, of what a database keeps."""
    found = {}
    with BagReader(bag) as reader:
        topics = [t for t in reader.topics if t in {'/site', '/tracks'} or t.endswith('/events')]
        for topic, _, data, time_ns in reader.serialized(topics):
            found.setdefault(topic, []).append((bytes(data), time_ns))
    return found


def test_fields_that_are_not_kept_are_said_once(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for k in range(3):
            rows = people(BEGAN_NS + k * TICK_NS, {1: (k, 0)})
            message = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
            message.fields.append(TYPES.types['sensor_msgs/msg/PointField']('mood', 0, 7, 1))
            writer.write('/tracks', message, rows.stamp_ns)
    with (
        Database(tmp_path / 'tracks.db', create=True) as database,
        pytest.warns(LeftOutWarning, match='/tracks: not stored: mood') as warned,
    ):
        store_bag(tmp_path / 'bag', database)
    assert len(warned) == 1


def test_a_bag_comes_back_byte_by_byte(database, tracked, tmp_path):
    run = store_bag(tracked, database)
    write_bag(database, tmp_path / 'bag', run=run.name)
    sent = log_of(tracked)
    assert len(sent['/tracks']) == 150
    assert sent.keys() == {'/site', '/tracks', '/events'}
    assert log_of(tmp_path / 'bag') == sent
