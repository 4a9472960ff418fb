import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.fusion.reid.appearance import AppearanceModel
from mctrack_ros.fusion.reid.lost_targets import ARRIVAL_DENSITY, MOST_LOST, LostTargets
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.tracking.kalman import predict

SECOND_NS = 1_000_000_000
RED, BLUE = np.eye(TEMPLATE_SIZE)[[0, 30]]
NOTHING = np.zeros(TEMPLATE_SIZE)


def tracks(states, ids, templates):
    table = TrackTable.blank(len(states), 2)
    table.mean = states
    table.covariance = np.diag([0.05, 0.05, 0.2, 0.2])
    table.track_id, table.template = ids, templates
    return table


@pytest.fixture
def lost():
    """One who goes right along y = 0, in red, and one along y = 1.5, in blue; lost at 0 s."""
    config = JointConfig()
    lost = LostTargets(config, AppearanceModel())
    lost.add(tracks([[0, 0, 1.4, 0], [0, 1.5, 1.4, 0]], [1, 2], [RED, BLUE]), 0)
    return lost


def found(lost, state, template=NOTHING, seconds=3.0):
    lost.expire(round(seconds * SECOND_NS))
    fresh = tracks([state], [9], [template])
    return lost.find(fresh, 0, NOTHING, round(seconds * SECOND_NS))


def test_who_comes_out_where_and_when_one_should_is_he(lost):
    assert found(lost, [4.2, 0, 1.4, 0]) == 1
    assert found(lost, [4.2, 1.5, 1.4, 0]) == 2


def test_who_comes_out_too_soon_or_elsewhere_is_somebody_new(lost):
    assert found(lost, [4.2, 0, 1.4, 0], seconds=0.4) == 0
    assert found(lost, [40, 0, 1.4, 0]) == 0


def test_what_it_costs_to_be_him_is_how_unlikely_his_state_is():
    """Against scipy's density of where he would be by now and of how surely both are known."""
    config, state, seconds = JointConfig(), np.array([4.2, 0.3, 1.1, 0.2]), 3.0
    lost = LostTargets(config, AppearanceModel())
    before = tracks([[0, 0, 1.4, 0]], [1], [NOTHING])
    lost.add(before, 0)
    assert found(lost, state, seconds=seconds) == 1
    motion = config.motion
    there, spread = predict(before.mean, before.covariance, seconds, motion.acceleration_density)
    his = multivariate_normal(there[0], spread[0] + before.covariance[0]).logpdf(state)
    speed = multivariate_normal(cov=INITIAL_SPEED_SIGMA**2 * np.eye(2))
    new = speed.logpdf(state[2:]) + np.log(ARRIVAL_DENSITY)
    assert lost.found[1] == pytest.approx(2 * (new - his))


def test_colours_tell_those_apart_who_come_out_together(lost):
    assert found(lost, [4.2, 0.75, 1.4, 0], RED) == 1
    assert found(lost, [4.2, 0.75, 1.4, 0], BLUE) == 2


def test_who_looks_like_neither_is_somebody_new(lost):
    assert found(lost, [4.2, 0.75, 1.4, 0], np.eye(TEMPLATE_SIZE)[15], 4.0) == 0


def test_the_longer_one_is_away_the_less_his_place_tells(lost):
    assert found(lost, [14, 0, 1.4, 0], seconds=10.0) == 0
    assert found(lost, [28, 0, 1.4, 0], seconds=21.0) == 0


def test_who_is_back_is_not_looked_for(lost):
    lost.remove(1)
    assert found(lost, [4.2, 0, 1.4, 0]) != 1


def test_of_a_flood_only_the_last_are_remembered(lost):
    ids = np.arange(10, 10 + MOST_LOST)
    lost.add(tracks(np.tile([100.0, 0, 0, 0], (MOST_LOST, 1)), ids, NOTHING), 1)
    assert found(lost, [4.2, 0, 1.4, 0]) == 0
    assert found(lost, [100.0, 0, 0, 0]) in ids
