"""A database that is whole passes the check; whatever is taken from it is found."""

import pytest

from mctrack_ros.interfaces import Tracks
from mctrack_ros.store import NewRun, TrajectoryWriter, check, store_bag

BEGAN_NS = 1_700_000_000_000_000_000


def test_what_was_stored_is_whole(database, tracked):
    store_bag(tracked, database)
    assert check(database) == []


@pytest.fixture
def walked(database):
    """Return a database of three walkers, one of whom is in the journal alone."""
    writer = TrajectoryWriter(database, NewRun('a'))
    for k in range(130):
        ids = [1, 2] if k < 110 else [1, 2, 3]
        position = [[k * 0.1, i, 0] for i in ids]
        writer.write_tracks(
            Tracks.build(
                BEGAN_NS + k * 40_000_000, track_id=ids, position=position, group=[5] * len(ids)
            )
        )
    writer.flush()
    return database


def test_the_table_of_tracks_counts_the_journal(walked):
    with walked.connected() as connection:
        asked = 'SELECT track_id, positions FROM tracks ORDER BY track_id'
        assert [tuple(row) for row in connection.exec_driver_sql(asked)] == [
            (1, 130),
            (2, 130),
            (3, 20),
        ]
    assert check(walked) == []


@pytest.mark.parametrize(
    ('taken', 'said'),
    [
        (
            'DELETE FROM rests WHERE chunk_id IN (SELECT min(chunk_id) FROM chunks)',
            'no second blob',
        ),
        ('DELETE FROM boxes WHERE chunk_id IN (SELECT min(chunk_id) FROM chunks)', 'another box'),
        (
            'DELETE FROM chunks WHERE chunk_id IN (SELECT min(chunk_id) FROM chunks)',
            'its messages had',
        ),
        ('DELETE FROM ticks WHERE span = 0', 'chunks are of spans without messages'),
        ('DELETE FROM journal', 'track 3: the table says'),
        ('UPDATE journal SET span = 0', 'the journal holds span 0, which is complete'),
        ('UPDATE chunks SET track_id = 9 WHERE span = 1 AND track_id = 1', 'track 9'),
        ('UPDATE tracks SET positions = 7 WHERE track_id = 1', 'track 1: the table says'),
        ('DELETE FROM groups', 'memberships are of no group'),
    ],
)
def test_what_does_not_agree_is_found(walked, taken, said):
    with walked.connected() as connection:
        connection.exec_driver_sql(taken)
    assert any(said in line for line in check(walked)), check(walked)
