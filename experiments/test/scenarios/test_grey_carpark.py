import numpy as np
import pytest

from mctrack_experiments.scenarios.grey_carpark import scores_of
from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.simulation import GREY_CARPARK, GreyCarParkScenario


@pytest.fixture(scope='module')
def world():
    return GREY_CARPARK.world(GreyCarParkScenario(seed=4))


def tracks_of(world, shown):
    """Return tracks of those shown, (steps, n), just where they are."""
    for step in range(world.scenario.steps):
        index = np.flatnonzero(shown[step])
        place = np.pad(world.motion.position[step, index], ((0, 0), (0, 1)))
        yield Tracks.build(
            world.scenario.stamp_ns(step),
            position=place,
            track_id=index + 1,
            class_id=world.class_id[index],
            status=np.full(len(index), TrackStatus.CONFIRMED),
        )


def test_tracks_that_are_the_truth_are_without_fault_and_those_on_parked_cars_do_not_count(world):
    for shown in (world.active, world.present):
        scores = scores_of(world, list(tracks_of(world, shown)))
        for kind in ('people', 'vehicles'):
            assert scores[f'{kind}.mota'] > 0.97
            assert scores[f'{kind}.mean_distance'] == pytest.approx(0, abs=1e-5)


def test_cars_taken_for_people_are_missing_and_false(world):
    instants = [
        rows.replace(class_id=np.ones_like(rows.class_id))
        for rows in tracks_of(world, world.active)
    ]
    scores = scores_of(world, instants)
    assert scores['vehicles.recall'] == 0.0
    assert scores['people.precision'] < 1.0
