"""Times in which nobody looked: whoever is there afterwards keeps the id."""

import numpy as np
import pytest

from fusion_scenes import tick
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.replay.proof.state import dump_state, go_on_with

CAMERAS = ('one', 'two')
RATE = 25


def seen(index, spread=0.0):
    """Return where two cameras see people who walk in circles, about each other or apart."""
    rng = np.random.default_rng(index)
    angle = 0.3 * index / RATE + np.arange(4) * np.pi / 2
    people = np.column_stack([np.cos(angle), np.sin(angle)]) * 4.0
    people += spread * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    return {name: people + rng.normal(0, 0.1, people.shape) for name in CAMERAS}


def ids(pipeline, indices, spread=0.0):
    """Return the ids of the people, in their order, after the last of some ticks."""
    for index in indices:
        tracks = pipeline.step(tick(index, seen(index, spread))).tracks
    people = np.mean(list(seen(indices[-1], spread).values()), axis=0)
    gap = np.linalg.norm(tracks.position[:, None, :2] - people, axis=2)
    assert (gap.min(axis=0) < 0.5).all()
    return tracks.track_id[gap.argmin(axis=0)].tolist()


@pytest.mark.parametrize('gap_s', [0.5, 1.5, 2.5, 3.0])
def test_people_keep_their_ids_over_a_time_without_ticks(gap_s):
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = ids(pipeline, range(50))
    begin = 50 + round(gap_s * RATE)
    assert ids(pipeline, range(begin, begin + 20)) == before


@pytest.mark.parametrize('gap_s', [5.0, 8.0])
def test_people_who_are_far_from_each_other_keep_their_ids_over_longer_times(gap_s):
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = ids(pipeline, range(50), spread=10.0)
    begin = 50 + round(gap_s * RATE)
    assert ids(pipeline, range(begin, begin + 20), spread=10.0) == before


def test_a_tracker_with_the_state_of_another_goes_on_as_that_one_would():
    pipeline, other = JointTracker(JointConfig(), CAMERAS), JointTracker(JointConfig(), CAMERAS)
    before = ids(pipeline, range(50))
    go_on_with(other, dump_state(pipeline, {}), first_id=900)
    later = range(100, 120)
    assert ids(other, later) == ids(pipeline, later) == before
    assert other.next_id == 900


def test_one_whom_only_a_camera_that_comes_back_later_sees_keeps_the_id():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = ids(pipeline, range(50))
    for index in range(100, 115):
        pipeline.step(tick(index, {'one': seen(index)['one'][:2]}))
    assert ids(pipeline, range(115, 135)) == before


def test_who_is_not_there_any_more_ends_after_the_usual_time():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    ids(pipeline, range(50))
    nobody = {name: np.zeros((0, 2)) for name in CAMERAS}
    for index in range(150, 150 + 2 * RATE):
        tracks = pipeline.step(tick(index, nobody)).tracks
    assert len(tracks) == 0
