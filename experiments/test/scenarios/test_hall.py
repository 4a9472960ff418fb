import numpy as np
import pytest

from mctrack_experiments.scenarios.hall import outcome_of, summary
from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.simulation import HALL, HallScenario


@pytest.fixture(scope='module')
def world():
    return HALL.world(HallScenario(seed=4))


def tracks_of(world, later=0, stays=False, one_a_group=False):
    """Return tracks of those who have been active for some steps, or who were so long ago."""
    for step in range(world.scenario.steps):
        past = max(step - later, 0)
        index = np.flatnonzero(world.active[past] & (stays | world.active[step]))
        place = world.motion.position[past if stays else step, index]
        place = np.pad(place, ((0, 0), (0, 1)))
        if one_a_group:
            index, place = index[:1], place[:1]
        yield Tracks.build(
            world.scenario.stamp_ns(step),
            position=place,
            track_id=index + 1,
            status=np.full(len(index), TrackStatus.CONFIRMED),
        )


def feet_of(world, off_m):
    """Return feet of those who are active, so far before them."""
    for step in range(world.scenario.steps):
        place = np.pad(world.motion.position[step, world.active[step]], ((0, 0), (0, 1)))
        yield Detections.build(
            world.scenario.stamp_ns(step),
            position=place - [off_m, 0, 0],
            score=np.ones(len(place)),
        )


def test_tracks_that_are_the_truth_are_without_fault(world):
    figures = summary([outcome_of(world, list(tracks_of(world)), list(feet_of(world, 0.0)))])
    assert figures['mota_0.5m'] == figures['idf1_1m'] == 1.0
    assert figures['feet.median_m'] == pytest.approx(0, abs=1e-5)
    assert figures['delay.p95_s'] == figures['false_s_per_min'] == 0.0
    assert figures['entering.tracks_per_person'] == 1.0
    assert figures['entering.short_share'] == figures['delay.never_share'] == 0.0


def test_late_tracks_come_late(world):
    late = list(tracks_of(world, later=25))
    figures = summary([outcome_of(world, late, list(feet_of(world, 0.2)))])
    assert 1.0 < figures['delay.median_s'] <= 2.0
    assert figures['false_s_per_min'] == 0.0
    assert 0.05 < figures['feet.median_m'] <= 0.2 + 1e-5


def test_tracks_that_stay_behind_are_left_over(world):
    outcome = outcome_of(world, list(tracks_of(world, later=25, stays=True)), [])
    assert 1.0 < outcome.left_over_s <= outcome.false_s


def test_one_track_for_all_who_come_in_is_too_few(world):
    outcome = outcome_of(world, list(tracks_of(world, one_a_group=True)), [])
    assert np.mean(outcome.entering) < 0.6
    assert len(outcome.feet) == 0
    assert outcome.left_over_s == 0.0
