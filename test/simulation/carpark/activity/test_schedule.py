import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark import CarParkScenario, carpark_world
from mctrack_ros.simulation.carpark.rendering.vehicles import footprint


@pytest.fixture(scope='module', params=[1, 2])
def world(request):
    return carpark_world(CarParkScenario(seed=request.param, duration_s=200))


def test_the_same_seed_is_the_same_recording():
    first, again, other = (
        carpark_world(CarParkScenario(seed=seed, duration_s=40)) for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first.motion.position, again.motion.position)
    assert first.motion.position.shape != other.motion.position.shape or not np.array_equal(
        first.motion.position, other.motion.position
    )


def test_something_goes_on_nearly_all_the_time(world):
    assert (world.active[40:-60].sum(axis=1) == 0).mean() < 0.1


def test_cars_come_park_and_leave(world):
    cars = world.class_id == ClassCode.VEHICLE
    came = cars & ~world.present[0] & world.parked[-1]
    left = cars & world.parked[0] & ~world.present[-1]
    assert came.any()
    assert left.any()


def test_a_car_is_parked_when_it_has_stood_for_four_seconds(world):
    place = world.motion.position
    moved = np.linalg.norm(np.diff(place, axis=0), axis=2) > 1e-3
    for step, car in np.argwhere(world.parked[1:] & ~world.parked[:-1]).tolist():
        assert not moved[step - 16 : step + 1, car].any()
        assert moved[step - 17, car]


def test_nobody_is_run_over_and_no_cars_touch(world):
    cars = np.flatnonzero(world.class_id == ClassCode.VEHICLE)
    speed = np.linalg.norm(world.motion.velocity, axis=2)
    for step in range(0, len(speed), 5):
        for car in cars[speed[step, cars] > 0.5].tolist():
            place, heading = world.motion.position[step, car], world.motion.heading[step, car]
            inside = footprint(np.zeros(2), 0.0, world.size[car])[2]
            apart = world.motion.position[step] - place
            ahead = apart @ np.array([np.cos(heading), np.sin(heading)])
            left = apart @ np.array([-np.sin(heading), np.cos(heading)])
            hit = (np.abs(ahead) < inside[0]) & (np.abs(left) < inside[1])
            assert np.flatnonzero(hit & world.present[step]).tolist() == [car]


def test_people_walk_no_faster_than_people_do(world):
    people = world.class_id == ClassCode.PERSON
    assert np.linalg.norm(world.motion.velocity[:, people], axis=2).max() < 2.2


def test_people_of_a_group_are_one_party():
    world = carpark_world(CarParkScenario(seed=2, duration_s=150))
    people = world.party[world.class_id == ClassCode.PERSON]
    assert len(np.unique(people)) < len(people)


def test_people_ride_through_on_bicycles_only_if_asked_for(world):
    scenario = CarParkScenario(seed=1, duration_s=120, bicycles=True)
    riding = carpark_world(scenario)
    riders = riding.class_id == ClassCode.BICYCLE
    assert riders.sum() >= 5
    speed = np.linalg.norm(riding.motion.velocity, axis=2)[riding.active]
    who = np.broadcast_to(riders, riding.active.shape)[riding.active]
    assert 2.5 < np.median(speed[who]) < 6.0
    assert not (world.class_id == ClassCode.BICYCLE).any()
