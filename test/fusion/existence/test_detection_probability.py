import numpy as np
import pytest

from mctrack_ros.fusion.existence.detection_probability import (
    LARGEST_PROBABILITY,
    DetectionProbability,
    expect,
    learn,
)

PRIOR = 0.6
SURE = np.ones(1, bool)


def teach(coverage, position, seen, watched, seconds):
    known, cell = coverage.seconds, coverage.cell
    learn(position, SURE, np.array([seen]), np.array([watched]), seconds, known, cell)


def expected(coverage, *place):
    probability = np.full(coverage.seconds.shape[-1], coverage.prior)
    expect(np.array(place), coverage.seconds, coverage.cell, probability)
    return probability


def test_what_is_not_known_is_assumed():
    coverage = DetectionProbability(2, 1.0, PRIOR)
    np.testing.assert_allclose(expected(coverage, 0.0, 0.0), PRIOR)


def test_a_camera_that_never_sees_a_place_is_not_expected_to():
    coverage = DetectionProbability(2, 1.0, PRIOR)
    place = np.array([[3.2, -7.9]])
    for _ in range(100):
        teach(coverage, place, [True, False], [True, True], 0.1)
    sees, blind = expected(coverage, *place[0])
    assert sees == LARGEST_PROBABILITY
    assert blind < 0.05


def test_neighbouring_cells_learn_a_little_and_far_ones_nothing():
    coverage = DetectionProbability(1, 1.0, PRIOR)
    for _ in range(100):
        teach(coverage, np.array([[0.5, 0.5]]), [False], [True], 0.1)
    (near,), (far,) = expected(coverage, 2.5, 0.5), expected(coverage, 99.0, 0.5)
    assert near < 0.2
    assert far == pytest.approx(PRIOR)


def test_images_that_are_not_there_teach_nothing():
    coverage = DetectionProbability(1, 1.0, PRIOR)
    teach(coverage, np.zeros((1, 2)), [False], [False], 10.0)
    np.testing.assert_allclose(expected(coverage, 0.0, 0.0), PRIOR)


def test_a_view_that_is_blocked_after_hours_is_soon_known_to_be():
    coverage = DetectionProbability(1, 1.0, PRIOR)
    for _ in range(20_000):
        teach(coverage, np.zeros((1, 2)), [True], [True], 0.2)
    for _ in range(300):
        teach(coverage, np.zeros((1, 2)), [False], [True], 0.2)
    assert expected(coverage, 0.0, 0.0)[0] < 0.2
