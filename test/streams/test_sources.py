import json

import pytest

from mctrack_ros.store import Database, NewRun, StoreError, TrajectoryWriter
from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.sources import Archive, RunFrames, about_run
from stream_story import ABOUT, PERIOD_NS, SITE, frames_of, stamp_ns, story, tracks

TICKS = 800
"""Sixteen spans of two seconds."""


@pytest.fixture(scope='module')
def long_story():
    """Return the messages of the story in the middle of a long walk."""
    first = TICKS // 2
    told = [
        (
            rows.at(rows.stamp_ns + first * PERIOD_NS),
            said and said.at(rows.stamp_ns + first * PERIOD_NS),
        )
        for rows, said in story()
    ]
    before = [(tracks(n, [1, 2, 3]), None) for n in range(first)]
    after = [(tracks(n, [1, 9]), None) for n in range(first + len(told), TICKS)]
    return [*before, *told, *after]


@pytest.fixture(scope='module')
def place(long_story, tmp_path_factory):
    """Return the place of a database with the run; its last span is not complete."""
    made = str(tmp_path_factory.mktemp('store') / 'tracks.db')
    with Database(made, create=True) as database:
        writer = TrajectoryWriter(database, NewRun(ABOUT.run))
        writer.write_description(json.dumps(SITE), stamp_ns(0))
        for rows, said in long_story:
            writer.write_tracks(rows)
            if said is not None:
                writer.write_events(said)
        writer.flush()
    return made


@pytest.fixture
def database(place):
    with Database(place) as opened:
        yield opened


def texts(frames):
    return [''.join(profile.frame(each) for profile in all_profiles()) for each in frames]


def test_a_run_is_streamed_as_it_was(database, long_story):
    about = about_run(database)
    assert about == ABOUT
    assert texts(RunFrames(database, about)) == texts(frames_of(long_story))


@pytest.mark.parametrize('after', [0, 3, 199, 399, 404, 405, 750, TICKS - 1])
def test_a_run_is_streamed_from_any_time_on(database, long_story, after):
    expected = texts(frames_of(long_story))
    source, found, last_ns = RunFrames(database, ABOUT, stamp_ns(after)), [], stamp_ns(after)
    while frames := source.next(last_ns):
        found += frames
        last_ns = found[-1].stamp_ns
    assert texts(found) == expected[after + 1 :]


def test_nothing_is_lost_where_the_memory_moves_on(database):
    source = RunFrames(database, ABOUT, stamp_ns(10))
    first = source.next(stamp_ns(10), stamp_ns(20))
    assert [each.stamp_ns for each in first] == [stamp_ns(n) for n in range(11, 20)]
    assert not source.next(stamp_ns(19), stamp_ns(20))
    second = source.next(stamp_ns(25), stamp_ns(40))
    assert [each.stamp_ns for each in second] == [stamp_ns(n) for n in range(26, 40)]


def test_a_database_may_be_made_later(tmp_path):
    later = tmp_path / 'later.db'
    with Archive(str(later)) as archive:
        source = RunFrames(archive, ABOUT)
        with pytest.raises(StoreError, match='no database'):
            source.next()
        with Database(later, create=True) as database:
            with pytest.raises(StoreError, match='no run'):
                source.next()
            with TrajectoryWriter(database, NewRun(ABOUT.run)) as writer:
                assert not source.next()
                writer.write_tracks(tracks(0, [1]))
        assert [each.stamp_ns for each in source.next()] == [stamp_ns(0)]
