import numpy as np
import pytest

from mctrack_ros.fusion.neighbours import near_pairs, nearest


@pytest.mark.parametrize('count', [0, 1, 2, 40])
def test_near_pairs_are_those_that_trying_all_finds(count):
    position = np.random.default_rng(count).uniform(0, 10, (count, 2))
    gap = np.linalg.norm(position[:, None] - position, axis=2)
    expected = np.argwhere(np.triu(gap < 2.0, 1))
    np.testing.assert_array_equal(np.column_stack(near_pairs(position, 2.0)), expected)


def test_many_in_one_place_are_all_near_each_other():
    one, other = near_pairs(np.zeros((30, 2)), 1.0)
    assert len(one) == 30 * 29 // 2
    assert (one < other).all()


def test_the_nearest_one_and_how_far_it_is():
    position = np.array([[0.0, 0.0], [5.0, 0.0]])
    others = np.array([[0.0, 0.5], [1.0, 0.0], [5.0, 2.0]])
    row, distance = nearest(position, others, np.array([False, True, True]))
    assert row.tolist() == [1, 2]
    assert distance.tolist() == [1.0, 2.0]
    assert nearest(position, others, np.zeros(3, bool))[1].tolist() == [np.inf, np.inf]
    assert nearest(position, np.zeros((0, 2)), np.zeros(0, bool))[1].tolist() == [np.inf, np.inf]
