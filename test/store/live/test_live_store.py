"""What comes is in the database, once and in order, however often it was away."""

import sqlite3
import time

import numpy as np
import pytest

from live_messages import serialised, site_message
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.store import Database, FeedOptions, LiveStore, Run, StoreError, events
from mctrack_ros.store.live.feed import Feed, FeedState
from mctrack_ros.store.live.spool import Spool

BEGAN_NS = 1_700_000_000_000_000_000
LIMIT = 100_000_000


def tracks(k, **columns):
    position = [[k * 0.1, 0, 0], [0, k * 0.1, 0]]
    return Tracks.build(BEGAN_NS + k * 40_000_000, track_id=[1, 2], position=position, **columns)


def exits(k):
    return Events.build(BEGAN_NS + k * 40_000_000, event=[EventCode.EXIT], track_id=[2])


class Written:
    """A spool and the feeds that write it, one after the other, without threads."""

    def __init__(self, place, folder, **options):
        self.database = Database(place, create=True)
        self.spool, self.options = Spool(folder, LIMIT, '/site'), FeedOptions(**options)
        self.begin()

    def begin(self):
        """Go on as another process does."""
        self.state = FeedState()
        self.feed = Feed(self.database, self.spool, self.options, self.state)

    def put(self, *messages):
        for topic, data in messages:
            self.spool.put(topic, BEGAN_NS, data)
        self.spool.save()

    def send(self, *ticks):
        self.put(*(('/tracks', serialised(tracks(k))) for k in ticks))

    def runs(self):
        """Return names, whether finished, and the ticks of the runs."""
        with self.database.connected() as connection:
            asked = 'SELECT name, ended_ns FROM runs WHERE began_ns IS NOT NULL ORDER BY run_id'
            found = connection.exec_driver_sql(asked).all()
        runs = {}
        for name, ended_ns in found:
            with Run(self.database, name) as run:
                stamps = np.unique(run.rows().stamp_ns)
            ticks = ((stamps - BEGAN_NS) // 40_000_000).tolist()
            runs[name] = (ended_ns is not None, ticks)
        return runs


@pytest.fixture
def written(place, tmp_path):
    return Written(place, tmp_path / 'spool')


def test_a_run_is_called_as_the_site_says_and_continued(written):
    written.put(('/site', site_message('r')))
    written.send(*range(80))
    written.feed.write()
    written.begin()
    written.put(('/site', site_message('r')))
    written.send(*range(80, 120))
    written.feed.write()
    assert written.runs() == {'r': (False, list(range(120)))}
    with Run(written.database) as run:
        assert run.cameras == ('north', 'south')
    assert written.spool.waiting == 0


def test_nothing_is_written_twice_whoever_died_before_the_spool_was_freed(written, monkeypatch):
    written.put(('/site', site_message('r')))
    for begin in range(0, 300, 60):
        written.send(*range(begin, begin + 60))
        written.put(('/events', serialised(exits(begin))))
        with monkeypatch.context() as patched:
            patched.setattr(written.spool, 'free', lambda number: None)
            written.feed.write()
        written.begin()
    written.feed.write()
    assert written.runs() == {'r': (False, list(range(300)))}
    with Run(written.database) as run:
        assert len(events(run)) == 5


def test_another_run_on_site_and_a_step_back_in_time_begin_another(written):
    written.put(('/site', site_message('a')))
    written.send(*range(200, 230))
    written.put(('/site', site_message('b')))
    written.send(*range(230, 260))
    written.send(*range(20, 40))
    written.feed.write()
    ticks = {name: ticks for name, (_, ticks) in written.runs().items()}
    expected = {'a': (200, 230), 'b': (230, 260), 'b-2': (20, 40)}
    assert ticks == {name: list(range(*each)) for name, each in expected.items()}
    assert [finished for finished, _ in written.runs().values()] == [True, True, False]
    said = list(written.state.said)
    assert 'run a is finished: /site names run b' in said
    assert any('run b is finished: time steps back' in line for line in said)


def test_runs_that_are_named_are_numbered(place, tmp_path):
    written = Written(place, tmp_path / 'spool', run='match')
    written.send(*range(100, 110))
    written.send(*range(10))
    written.feed.write()
    assert list(written.runs()) == ['match', 'match-2']


def test_a_finished_run_is_not_continued_and_that_is_said(place, tmp_path):
    written = Written(place, tmp_path / 'spool', run='match', finish=True)
    written.send(*range(10))
    written.feed.write()
    written.feed.close()
    written.begin()
    written.send(*range(10, 20))
    written.feed.write()
    runs = written.runs()
    assert runs == {'match': (True, list(range(10))), 'match-2': (False, list(range(10, 20)))}
    assert 'run match is finished: another one begins' in written.state.said


def test_what_cannot_be_used_is_refused_and_counted(written):
    further = Tracks.build(BEGAN_NS, track_id=[1], position=[[0, 0, 0]])
    written.put(
        ('/tracks', b'nothing'),
        ('/site', site_message('r')),
        ('/tracks', serialised(further)),
        ('/tracks', serialised(further)),
        ('/tracks', serialised(tracks(1), 'odom')),
        ('/site', b'\0\1\0\0\3\0\0\0{]\0'),
        ('/events', serialised(exits(2), 'odom')),
        ('/north/events', serialised(exits(2))),
    )
    written.feed.write()
    assert (written.state.written, written.state.refused) == (2, 5)
    assert sum('refused' in line for line in written.state.said) == 3


def test_fields_that_are_not_kept_are_said_once(written):
    for k in range(3):
        message = cloud_from_rows(tracks(k), ROSBAGS_CLASSES, 'map')
        message.fields.append(TYPES.types['sensor_msgs/msg/PointField']('mood', 0, 7, 1))
        data = bytes(TYPES.serialize_cdr(message, message.__msgtype__))
        written.put(('/tracks', data))
    written.feed.write()
    assert [line for line in written.state.said if 'mood' in line] == ['/tracks: not stored: mood']


def until(condition):
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end, 'what was waited for did not happen'
        time.sleep(0.02)


def test_the_spool_bridges_a_database_that_is_locked(tmp_path, monkeypatch):
    monkeypatch.setattr('mctrack_ros.store.database._BUSY_S', 0.2)
    path = tmp_path / 'tracks.db'
    with LiveStore(path, tmp_path / 'spool', LIMIT, FeedOptions(run='r')) as store:
        for k in range(5):
            store.put('/tracks', BEGAN_NS, serialised(tracks(k)))
        until(lambda: store.state.written == 5)
        other = sqlite3.connect(path, isolation_level=None)
        other.execute('BEGIN EXCLUSIVE')
        for k in range(5, 10):
            store.put('/tracks', BEGAN_NS, serialised(tracks(k)))
        until(lambda: 'locked' in store.failure)
        assert store.spool.waiting == 5
        other.execute('ROLLBACK')
        until(lambda: store.state.written == 10)
        until(lambda: store.failure == '')
    other.close()
    with Run(path) as run:
        assert len(np.unique(run.rows().stamp_ns)) == 10


def test_what_could_not_be_written_is_written_by_the_next(tmp_path):
    path, folder = tmp_path / 'tracks.db', tmp_path / 'spool'
    path.write_text('no database, but a text of some length, and then some more of it' * 9)
    with LiveStore(path, folder, LIMIT, FeedOptions(run='r')) as store:
        for k in range(50):
            store.put('/tracks', BEGAN_NS, serialised(tracks(k)))
        until(lambda: 'not a database' in store.failure)
    assert store.spool.waiting == 50
    path.unlink()
    with LiveStore(path, folder, LIMIT, FeedOptions(run='r')) as store:
        until(lambda: store.state.written == 50)
    with Run(path) as run:
        assert len(np.unique(run.rows().stamp_ns)) == 50


def test_a_place_with_a_password_is_refused(tmp_path):
    for url in ('postgresql://me:secret@/tracks', 'postgresql://me@/tracks?password=secret'):
        with pytest.raises(StoreError, match='holds a password') as raised:
            LiveStore(url, tmp_path / 'spool', LIMIT, FeedOptions())
        assert 'secret' not in str(raised.value)
