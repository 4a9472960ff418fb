import numpy as np
import pytest

from mctrack_ros.simulation import LENGTH_M, WIDTH_M, Scenario
from mctrack_ros.simulation.pitch.players import MAX_ACCELERATION, MAX_SPEED, simulate_motion


@pytest.fixture(scope='module', params=[1, 7])
def motion(request):
    return simulate_motion(Scenario(seed=request.param, duration_s=30))


def test_nobody_runs_faster_than_people_do(motion):
    assert np.linalg.norm(motion.velocity, axis=2).max() <= MAX_SPEED


def test_nobody_speeds_up_harder_than_people_do(motion):
    change = np.diff(motion.velocity, axis=0) * 25
    assert np.linalg.norm(change, axis=2).max() <= MAX_ACCELERATION + 1e-9


def test_positions_follow_from_velocities(motion):
    mean = (motion.velocity[1:] + motion.velocity[:-1]) / 2
    np.testing.assert_allclose(np.diff(motion.position, axis=0), mean / 25, atol=1e-12)


def test_everybody_stays_about_the_pitch(motion):
    assert motion.position.min() > -3
    assert motion.position[..., 0].max() < LENGTH_M + 3
    assert motion.position[..., 1].max() < WIDTH_M + 3


def test_nobody_stands_inside_another(motion):
    apart = np.linalg.norm(motion.position[:, :, None] - motion.position[:, None], axis=3)
    apart += np.eye(apart.shape[1]) * 10
    assert (apart.min(axis=2) < 0.3).mean() < 0.01


def test_some_stand_and_some_run(motion):
    speed = np.linalg.norm(motion.velocity, axis=2)
    assert (speed < 0.3).mean() > 0.05
    assert (speed > 4).mean() > 0.05


def test_a_shorter_match_is_the_beginning_of_a_longer_one():
    short, long = (simulate_motion(Scenario(duration_s=seconds)) for seconds in (2, 4))
    np.testing.assert_array_equal(short.position, long.position[: len(short.position)])
