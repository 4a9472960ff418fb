"""The past of a run that is still being written."""

import numpy as np
import pytest

from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.store import Database, NewRun, StoreError, TrajectoryWriter
from mctrack_ros.web.live import past
from mctrack_ros.web.live.frames import HEAD, PAST, ROW
from mctrack_ros.web.live.past import Past

BEGAN_S = 1_700_000_000
SECONDS, RATE_HZ = 5, 10


@pytest.fixture
def place(tmp_path):
    """Return a database with five seconds of two people, the last of them in the journal."""
    path = tmp_path / 'tracks.db'
    with Database(path, create=True) as database:
        with TrajectoryWriter(database, NewRun('earlier')) as earlier:
            earlier.write_tracks(tracks(BEGAN_S - 1000, 1.0))
        writer = TrajectoryWriter(database, NewRun('now'), clock=lambda: 0.0)
        for k in range(SECONDS * RATE_HZ):
            rows = tracks(BEGAN_S + k / RATE_HZ, k / RATE_HZ)
            writer.write_tracks(rows)
            if k == 20:
                event = {'track_id': [1], 'event': [EventCode.NEW], 'position': rows.position[:1]}
                writer.write_events(Events.build(rows.stamp_ns, **event))
        writer.flush()
        yield path


def tracks(time_s, x):
    return Tracks.build(
        round(time_s * 1e9), position=[(x, 0, 0), (x, 5, 0)], track_id=[1, 2], cameras=[3, 1]
    )


def test_a_run_that_is_written_is_seen_to_its_last_flush(place):
    shown = Past(place)
    extent = shown.extent()
    assert (extent.run, extent.began_s) == ('now', BEGAN_S)
    assert extent.ended_s >= BEGAN_S + SECONDS
    block = shown.block(BEGAN_S + 4.5)
    kind, _, _, count, first_s, until_s = HEAD.unpack_from(block.message)
    assert (kind, count) == (PAST, 2 * SECONDS * RATE_HZ)
    assert first_s <= BEGAN_S + 4.5 < until_s
    rows = np.frombuffer(block.message, ROW, offset=HEAD.size)
    time_s = first_s - BEGAN_S + rows['after'].astype(np.float64)
    np.testing.assert_allclose(time_s, rows['position'][:, 0], atol=1e-3)
    assert time_s[-1] == pytest.approx(SECONDS - 1 / RATE_HZ, abs=1e-3)
    assert rows['cameras'][:2].tolist() == [3, 1]
    (event,) = block.events
    assert (event['event'], event['track'], event['place']) == ('new', 1, [2.0, 0.0])
    assert event['time'] == BEGAN_S + 2
    shown.close()


def test_when_somebody_was_seen_last(place):
    shown = Past(place)
    assert shown.last_seen(2, BEGAN_S + 100) == pytest.approx(BEGAN_S + 4.9)
    assert shown.last_seen(2, BEGAN_S + 2.05) == pytest.approx(BEGAN_S + 2.0)
    assert shown.last_seen(77, BEGAN_S + 100) is None
    shown.close()


def test_many_rows_are_thinned_by_instants(place, monkeypatch):
    monkeypatch.setattr(past, 'MOST_ROWS', 30)
    shown = Past(place)
    message = shown.block(BEGAN_S + 1).message
    rows = np.frombuffer(message, ROW, offset=HEAD.size)
    assert len(rows) <= 30
    _, each = np.unique(rows['after'], return_counts=True)
    assert set(each.tolist()) == {2}
    shown.close()


def test_a_database_may_come_later(tmp_path):
    shown = Past(tmp_path / 'tracks.db')
    with pytest.raises(StoreError, match='there is no database'):
        shown.extent()
    with Database(tmp_path / 'tracks.db', create=True) as database:
        with pytest.raises(StoreError, match='no run with tracks yet'):
            shown.extent()
        with TrajectoryWriter(database, NewRun('first')) as writer:
            writer.write_tracks(tracks(BEGAN_S, 0.0))
    assert shown.extent().run == 'first'
    shown.close()
