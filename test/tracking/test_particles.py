"""Particles are drawn as filterpy draws them, and the same again."""

import numpy as np
import pytest
from filterpy.monte_carlo import systematic_resample

from mctrack_ros.tracking.particles import (
    effective_size,
    log_mixture,
    moved,
    normalised,
    stream,
    systematic_rows,
    whitened,
)


def test_rows_are_those_of_filterpy_with_the_same_offset():
    rng = np.random.default_rng(2)
    for seed in range(20):
        weight = rng.dirichlet(np.full(50, 0.3))
        np.random.seed(seed)  # noqa: NPY002
        expected = systematic_resample(weight)
        np.random.seed(seed)  # noqa: NPY002
        offset = np.random.random()  # noqa: NPY002
        np.testing.assert_array_equal(systematic_rows(weight, offset), expected)


def test_weights_that_sum_to_less_by_rounding_do_not_index_past_the_end():
    assert systematic_rows(np.full(3, 0.3), 0.999999).max() == 2


def test_log_weights_far_below_zero_and_all_zero_ones_are_normalised():
    np.testing.assert_allclose(normalised([-5000.0, -5000.0 + np.log(3)]), [0.25, 0.75])
    np.testing.assert_allclose(normalised(np.full(4, -np.inf)), 0.25)


def test_effective_size_is_the_number_of_equal_weights():
    assert effective_size(np.full(10, 0.1)) == pytest.approx(10)
    assert effective_size(np.eye(5)[0]) == pytest.approx(1)


def test_streams_depend_on_seed_name_and_stamp_alone():
    keys = [(1, 'a', 5), (2, 'a', 5), (1, 'b', 5), (1, 'a', 6)]
    drawn = [stream(*key).random() for key in keys]
    assert len(set(drawn)) == 4
    assert drawn == [stream(*key).random() for key in keys]


def test_spread_grows_as_white_acceleration_says():
    noise = np.random.default_rng(1).normal(size=(2, 200_000, 1))
    place, velocity = moved(np.zeros((200_000, 1)), np.ones((200_000, 1)), 2.0, 0.5, noise)
    assert place.mean() == pytest.approx(2.0, abs=0.02)
    assert place.var() == pytest.approx(0.5 * 2.0**3 / 3, rel=0.02)
    assert velocity.var() == pytest.approx(0.5 * 2.0, rel=0.02)


def test_sets_are_drawn_each_by_its_own_weights():
    weight = np.random.default_rng(3).dirichlet(np.full(30, 0.4), size=(2, 3))
    offset = np.random.default_rng(4).random((2, 3))
    rows = systematic_rows(weight, offset)
    for index in np.ndindex(2, 3):
        np.testing.assert_array_equal(rows[index], systematic_rows(weight[index], offset[index]))


def test_mixtures_are_those_of_the_motion_model():
    rng = np.random.default_rng(7)
    place, velocity, density = rng.normal(size=(1, 40, 2)), rng.normal(size=(1, 40, 2)), 1.5
    then, speed = moved(place, velocity, 0.5, density, rng.normal(size=(2, 1, 40, 2)))
    mean = whitened(place + 0.5 * velocity, velocity, 0.5)
    found = log_mixture(whitened(then, speed, 0.5), mean, np.full(mean.shape, density))
    block = density * np.array([[0.5**3 / 3, 0.5**2 / 2], [0.5**2 / 2, 0.5]])
    expected = np.empty(40)
    for row in range(40):
        drift = then[0, row] - place[0] - 0.5 * velocity[0]
        offset = np.stack([drift, speed[0, row] - velocity[0]], axis=2)
        squared = np.einsum('rai,ij,raj->r', offset, np.linalg.inv(block), offset)
        expected[row] = np.log(np.exp(-squared / 2).mean())
    # Whitened coordinates differ by a constant volume.
    np.testing.assert_allclose(found[0] - found[0, 0], expected - expected[0], atol=1e-3)
