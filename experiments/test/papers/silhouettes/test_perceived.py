import numpy as np
import pytest

from mctrack_experiments.papers.silhouettes.perceived import (
    Sightings,
    activity_table,
    perceived_events,
)

APART = np.empty((0, 2), np.int64)
HERE, THERE, FAR = (10.0, 10.0, 20.0, 50.0), (60.0, 10.0, 20.0, 50.0), (400.0, 300.0, 20.0, 50.0)


def sightings(*rows):
    """Return sightings of (key, first step, last step, box)."""
    flat = [(step, key, box) for key, first, last, box in rows for step in range(first, last + 1)]
    return Sightings(
        np.array([step for step, *_ in flat], np.int64),
        np.array([key for _, key, _ in flat], np.int64),
        np.array([box for *_, box in flat], float).reshape(-1, 4),
    )


def cells(truth, tracks, together=APART, unjudged=None):
    """Return the (true, counted) numbers of all events."""
    events = perceived_events(truth, np.array(together), tracks, 0.25, unjudged)
    return sorted((len(event.subjects), event.counted) for event in events)


@pytest.mark.parametrize(
    ('tracks', 'cell'),
    [
        ([(7, 0, 19, HERE)], (1, 1)),
        ([(7, 0, 9, HERE), (8, 10, 19, HERE)], (1, 2)),
        ([(7, 0, 19, HERE), (8, 5, 7, (12.0, 40.0, 8.0, 15.0))], (1, 2)),
        ([(7, 0, 5, HERE)], (1, 0)),
        ([], (1, 0)),
    ],
    ids=['followed', 'lost and found', 'fragment', 'mostly lost', 'never seen'],
)
def test_one_pedestrian_alone(tracks, cell):
    assert cells(sightings((1, 0, 19, HERE)), sightings(*tracks)) == [cell]


def test_those_who_touch_are_one_event_and_others_two():
    truth = sightings((1, 0, 9, HERE), (2, 0, 9, THERE))
    tracks = sightings((7, 0, 9, HERE), (8, 0, 9, THERE))
    assert cells(truth, tracks, [(1, 2)]) == [(2, 2)]
    assert cells(truth, tracks) == [(1, 1), (1, 1)]


def test_a_pedestrian_lost_in_a_merge_is_below_the_diagonal():
    truth = sightings((1, 0, 9, HERE), (2, 0, 9, THERE))
    assert cells(truth, sightings((7, 0, 9, HERE)), [(1, 2)]) == [(2, 1)]


def test_a_fragment_does_not_stand_in_for_somebody_lost():
    truth = sightings((1, 0, 9, HERE), (2, 0, 9, THERE))
    tracks = sightings((7, 0, 9, HERE), (8, 3, 6, HERE))
    assert cells(truth, tracks, [(1, 2)]) == [(2, 1)]


def test_tracks_on_nothing_are_one_event_where_they_are_near():
    tracks = sightings((7, 0, 9, HERE), (8, 12, 15, THERE), (9, 0, 9, FAR), (10, 90, 95, HERE))
    assert cells(sightings(), tracks) == [(0, 1), (0, 1), (0, 2)]


def test_a_track_that_strays_counts_where_it_is_most():
    truth = sightings((1, 0, 9, HERE), (2, 0, 9, FAR))
    tracks = sightings((7, 0, 6, HERE), (7, 7, 9, FAR), (8, 0, 9, FAR))
    assert cells(truth, tracks) == [(1, 1), (1, 1)]


def test_tracks_of_what_is_too_short_for_an_event_are_not_counted():
    hidden = sightings((3, 0, 5, FAR))
    tracks = sightings((7, 0, 9, HERE), (8, 0, 5, FAR))
    assert cells(sightings((1, 0, 9, HERE)), tracks, unjudged=hidden) == [(1, 1)]


def test_the_table_counts_the_cells():
    truth = sightings((1, 0, 9, HERE), (2, 0, 9, FAR))
    events = perceived_events(truth, APART, sightings((7, 0, 9, HERE)), 0.25)
    np.testing.assert_array_equal(activity_table(events).counts, [[0, 0], [1, 1]])
