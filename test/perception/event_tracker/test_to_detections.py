import numpy as np
import pytest

from mctrack_ros.perception.blob_split.measurements import Observations
from mctrack_ros.perception.event_tracker.to_detections import reported_persons, sighted

SECOND_NS = 1_000_000_000


def person(fitted=False, visible=1.0):
    """One person of track 1, in blob 0."""
    return Observations(
        np.array([1]),
        np.array([0]),
        np.array([[10.0, 20.0, 4.0, 10.0]]),
        np.zeros((1, 2)),
        np.array([[3.0, 4.0]]),
        np.zeros((1, 2, 2)),
        np.array([visible]),
        np.ones(1),
        np.full((1, 48), 0.25),
        np.array([fitted]),
        np.zeros((1, 2)),
    )


def reported(seen, age_s=1.0, truncated=True):
    first_ns = np.array([0, round((5 - age_s) * SECOND_NS)])
    return reported_persons(
        seen,
        np.array([33.0]),
        np.array([truncated]),
        np.tile([8.0, 5.0, 0.0], (9, 9, 1)),
        first_ns,
        np.array([5, 6]),
        np.array([0, 70]),
        np.full((2, 48), 0.5),
        5 * SECOND_NS,
        0.2,
    )


def test_a_blob_is_told_with_its_own_area_and_the_ids_of_its_track():
    row = reported(person())
    assert (row.area[0], row.local_id[0], row.track_id[0], row.truncated[0]) == (33, 6, 70, 1)
    assert row.position[0].tolist() == [3, 4, 0]


def test_a_body_is_told_with_the_area_that_is_seen_of_it():
    assert reported(person(fitted=True, visible=0.5)).area[0] == 20


def test_who_is_alone_in_a_whole_blob_is_told_with_his_size():
    """His box is 4 px wide and 10 px high where a metre is 8 px across and 5 px upright."""
    assert reported(person(), truncated=False).extent.tolist() == [[0.5, 2.0]]
    assert np.isnan(reported(person()).extent).all()
    assert np.isnan(reported(person(fitted=True), truncated=False).extent).all()


@pytest.mark.parametrize(('visible', 'colour'), [(0.2, 0.5), (0.9, 0.25)])
def test_of_a_hidden_body_the_colours_are_those_remembered(visible, colour):
    assert (reported(person(fitted=True, visible=visible)).template == colour).all()


@pytest.mark.parametrize(('age_s', 'score'), [(0.0, 0.1), (0.1, 0.5), (1.0, 1.0)])
def test_a_young_track_is_less_certain(age_s, score):
    assert reported(person(), age_s).score[0] == pytest.approx(score)


def test_believed_tracks_are_sighted_whether_seen_or_not():
    mean = np.array([[1.0, 2, 0, 0], [3, 4, 0, 0], [5, 6, 0, 0]])
    confirmed, first_ns = np.array([True, True, False]), np.zeros(3, np.int64)
    ids, place, box, is_seen, proven, age_s = sighted(
        person(), confirmed, np.array([7, 8, 9]), mean, first_ns, SECOND_NS
    )
    assert (ids.tolist(), is_seen.tolist()) == ([7, 8], [False, True])
    assert (place.tolist(), proven.tolist()) == ([[1, 2], [3, 4]], [0, 1])
    assert (box[1].tolist(), age_s.tolist()) == ([10, 20, 4, 10], [1, 1])
