from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import IMMEstimator, KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm

from fusion_scenes import tick
from mctrack_ros.config import config_from, parameters_of
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.measurements.packed import measured
from mctrack_ros.fusion.motion import config as fusion_config
from mctrack_ros.fusion.motion.information import gathered
from mctrack_ros.fusion.motion.models import MODELS, ConstantVelocity, InteractingModels
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import REPORTED
from mctrack_ros.tracking.kalman import position_matrix, transition_matrix

TICK_S = 0.04
MOTION = InteractingModels((0.2, 8.0), (2.0, 0.5))
NOISE = np.array([[0.03, 0.01], [0.01, 0.02]])


class Seen(NamedTuple):
    """What `gathered` asks of detections."""

    seconds: NDArray[np.float64]
    image: NDArray[np.int64]
    track: NDArray[np.int64]
    detection: NDArray[np.int64]
    probability: NDArray[np.float64]
    measured: NDArray[np.float64]


def tracks(count, seed, motion=MOTION):
    rng = np.random.default_rng(seed)
    table = TrackTable.blank(count, 2, motion.modes)
    table.mean[:] = rng.normal(0, 2, (count, 4))
    spread = rng.normal(size=(count, 4, 4))
    table.covariance[:] = spread @ spread.swapaxes(1, 2) + 0.1 * np.eye(4)
    motion.begin(table)
    return table


def told(table, rng, seconds=(0.0,), probability=1.0):
    """Detections about where each track is, one of each in every image."""
    images, count = len(seconds), len(table)
    image, track = (each.ravel() for each in np.mgrid[:images, :count])
    place = np.tile(table.mean[:, :2], (images, 1)) + rng.normal(0, 0.3, (images * count, 2))
    rows = np.arange(images * count)
    seen = measured(place, np.tile(NOISE, (len(rows), 1, 1)), rows)
    share = np.full(len(rows), probability)
    return Seen(np.array(seconds), image, track, rows, share, seen)


def learn(motion, table, seen):
    gains = gathered(table.mean, *seen)
    motion.update(table, gains)


def oracle(table, row, motion):
    """Filterpy's estimator of one track."""
    filters = []
    for mode, density in enumerate(motion.densities):
        one = KalmanFilter(dim_x=4, dim_z=2)
        one.x, one.P = table.mode_mean[row, mode].copy(), table.mode_covariance[row, mode].copy()
        one.F, one.H, one.R = transition_matrix(TICK_S), position_matrix(), NOISE
        one.Q = Q_continuous_white_noise(2, TICK_S, density, 2, order_by_dim=False)
        filters.append(one)
    shares = table.mode_probability[row].copy()
    return IMMEstimator(filters, shares, motion.transition(TICK_S))


@pytest.mark.parametrize('seconds', [0.0, 0.04, 0.7, 100.0])
def test_modes_change_into_one_another_as_often_as_they_last(seconds):
    """The Markov chain in continuous time that leaves each mode once in its mean duration."""
    rates = np.array([[-1 / 2.0, 1 / 2.0], [1 / 0.5, -1 / 0.5]])
    np.testing.assert_allclose(MOTION.transition(seconds), expm(rates * seconds), atol=1e-12)


def test_it_is_filterpys_estimator_where_every_detection_is_somebodys_for_certain():
    table, rng = tracks(3, 1), np.random.default_rng(2)
    singles = [oracle(table, row, MOTION) for row in range(3)]
    for _ in range(30):
        MOTION.predict(table, TICK_S)
        seen = told(table, rng)
        for row, single in enumerate(singles):
            single.predict()
            single.update(seen.measured[row, :2])
        learn(MOTION, table, seen)
    for row, single in enumerate(singles):
        np.testing.assert_allclose(table.mode_probability[row], single.mu, atol=1e-9)
        np.testing.assert_allclose(table.mean[row], single.x, atol=1e-9)
        np.testing.assert_allclose(table.covariance[row], single.P, atol=1e-9)


@pytest.mark.parametrize('probability', [1.0, 0.4])
def test_modes_that_are_alike_are_one_filter(probability):
    alike, single = InteractingModels((2.0, 2.0), (2.0, 0.5)), ConstantVelocity(2.0)
    table, rng = tracks(4, 3, alike), np.random.default_rng(4)
    plain = tracks(4, 3, single)
    for _ in range(20):
        seen = told(plain, rng, (-0.01, 0.0), probability)
        for motion, some in ((alike, table), (single, plain)):
            motion.predict(some, TICK_S)
            learn(motion, some, seen)
    np.testing.assert_allclose(table.mean, plain.mean, atol=1e-9)
    np.testing.assert_allclose(table.covariance, plain.covariance, atol=1e-9)
    np.testing.assert_allclose(table.mode_probability, [[0.8, 0.2]] * 4, atol=1e-9)


def test_several_images_judge_the_modes_as_one_after_the_other_would():
    table, seconds = tracks(2, 5), (-0.02, 0.0)
    MOTION.predict(table, TICK_S)
    table.mode_mean[:, 1] += 0.1
    seen = told(table, np.random.default_rng(6), seconds)
    expected = table.mode_probability.copy()
    for row, mode in np.ndindex(2, 2):
        state = table.mode_mean[row, mode], table.mode_covariance[row, mode]
        for pair in np.flatnonzero(seen.track == row):
            single = KalmanFilter(dim_x=4, dim_z=2)
            single.x, single.P = state
            single.H, single.R = position_matrix(seconds[seen.image[pair]]), NOISE
            single.update(seen.measured[pair, :2])
            expected[row, mode] *= single.likelihood
            state = single.x, single.P
    learn(MOTION, table, seen)
    expected /= expected.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(table.mode_probability, expected, atol=1e-9)


@settings(deadline=None, max_examples=50)
@given(
    seed=st.integers(0, 10**6),
    seconds=st.floats(0, 20),
    probability=st.floats(0, 1),
    far=st.floats(0, 1e4),
)
def test_whatever_is_told_the_mixture_stays_one(seed, seconds, probability, far):
    table, rng = tracks(3, seed), np.random.default_rng(seed)
    for _ in range(5):
        MOTION.predict(table, seconds)
        seen = told(table, rng, probability=probability)
        seen.measured[:, :2] += far
        learn(MOTION, table, seen)
        np.testing.assert_allclose(table.mode_probability.sum(axis=1), 1.0)
        assert (table.mode_probability >= 0).all()
        assert (np.linalg.eigvalsh(table.covariance) > 0).all()
        within = np.einsum('nm,nmi->ni', table.mode_probability, table.mode_mean)
        np.testing.assert_allclose(table.mean, within, atol=1e-6 * (1 + far))


@given(st.floats(0, 100), st.floats(0, 100))
def test_going_on_twice_is_going_on_once_for_both_times(one, other):
    twice = MOTION.transition(one) @ MOTION.transition(other)
    np.testing.assert_allclose(twice, MOTION.transition(one + other), atol=1e-12)
    np.testing.assert_allclose(twice.sum(axis=1), 1.0)


def test_of_whom_nothing_is_told_the_modes_are_only_predicted():
    table, rng = tracks(2, 7), np.random.default_rng(8)
    MOTION.predict(table, TICK_S)
    before = table.records.copy()
    seen = told(table, rng)
    learn(MOTION, table, seen._replace(track=seen.track * 0))
    for name in before.dtype.names:
        np.testing.assert_array_equal(table.records[1][name], before[1][name])
    assert (table.mode_mean[0] != before[0]['mode_mean']).any()


def test_modes_follow_a_state_that_was_changed_otherwise():
    table = tracks(3, 9)
    others = table.mode_covariance[[0, 2]]
    table.mean[1] += 1.0
    table.covariance[1] *= 2.0
    MOTION.follow(table, np.array([1]))
    np.testing.assert_array_equal(table.mode_mean[1], np.tile(table.mean[1], (2, 1)))
    np.testing.assert_array_equal(
        table.mode_covariance[1], np.tile(table.covariance[1], (2, 1, 1))
    )
    np.testing.assert_array_equal(table.mode_covariance[[0, 2]], others)
    MOTION.predict(table, 0.0)
    np.testing.assert_allclose(table.mode_mean[1, 0], table.mean[1])


def test_the_duplicate_that_is_better_known_brings_its_modes_along():
    table = tracks(2, 10)
    table.covariance[1] /= 4
    table.mode_covariance[1] /= 4
    table.absorb(0, 1)
    for name in ('mode_mean', 'mode_covariance', 'mode_probability'):
        np.testing.assert_array_equal(getattr(table, name)[0], getattr(table, name)[1])


def test_every_model_can_be_named():
    model = next(each for each in parameters_of(JointConfig) if each.name == 'motion.model')
    assert model.choices == tuple(MODELS)


def turning_walker(seconds=16.0):
    """Places and velocities of one who walks straight, turns sharply, and so on."""
    steps = np.arange(round(seconds / TICK_S))
    turns = (steps % 100 >= 80) * (np.pi / 2) / 20
    heading = np.cumsum(turns)
    velocity = 2.5 * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.cumsum(velocity, axis=0) * TICK_S, velocity


def followed(model, seed):
    """Return the errors (n, 4) and covariances (n, 4, 4) of the walker's track, once settled."""
    config = JointConfig()
    motion = config_from(fusion_config.MOTION, {'model': model, 'sensor_sigma': 0.001})
    pipeline = JointTracker(replace(config, motion=motion), ('one', 'two'))
    places, velocity = turning_walker()
    rng, errors, spreads = np.random.default_rng(seed), [], []
    for index, place in enumerate(places):
        seen = {name: [place + rng.normal(0, 0.1, 2)] for name in ('one', 'two')}
        tracks = pipeline.step(tick(index, seen)).tracks
        tracks = tracks.select(np.isin(tracks.status, REPORTED))
        if index >= 50:
            assert len(tracks) == 1
            state = np.append(tracks.position[0, :2], tracks.velocity[0])
            errors.append(state - np.append(place, velocity[index]))
            spreads.append(tracks.covariance[0])
    return np.array(errors), np.array(spreads)


def consistency(runs):
    """Return the rms error of the place, m, and the NEES of the state, per value."""
    errors, spreads = (np.concatenate(each) for each in zip(*runs))
    solved = np.linalg.solve(spreads.astype(float), errors[..., None])[..., 0]
    rms = np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean())
    return rms, (errors * solved).sum(axis=1).mean() / 4


def test_who_turns_is_followed_with_less_error_and_is_more_as_wrong_as_told():
    plain, interacting = (
        consistency([followed(model, seed) for seed in range(3)]) for model in MODELS
    )
    assert interacting[0] < 0.95 * plain[0]
    assert abs(np.log(interacting[1])) < abs(np.log(plain[1]))
