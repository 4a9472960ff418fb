"""Covariance intersection never claims more than is known, whatever the errors share."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.fusion.cells.intersection import intersection


def random_joint(rng, count):
    """Return a covariance of several estimates of one state, correlated in any way."""
    root = rng.normal(size=(4 * count, rng.integers(4, 4 * count + 3)))
    return root @ root.T + 1e-3 * np.eye(4 * count)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_the_covariance_covers_the_true_error(seed, count):
    rng = np.random.default_rng(seed)
    joint = random_joint(rng, count)
    own = np.array([joint[4 * i : 4 * i + 4, 4 * i : 4 * i + 4] for i in range(count)])
    part = np.zeros(count, np.intp)
    _, covariance = intersection(np.zeros((count, 4)), own, part, 1)
    # The result is linear in the estimates: each one's share shows what it makes of their errors.
    shares = []
    for index in range(count):
        share = np.empty((4, 4))
        for axis in range(4):
            mean = np.zeros((count, 4))
            mean[index, axis] = 1.0
            share[:, axis] = intersection(mean, own, part, 1)[0][0]
        shares.append(share)
    gain = np.hstack(shares)
    true = gain @ joint @ gain.T
    assert np.linalg.eigvalsh(covariance[0] - true).min() > -1e-6 * np.trace(true)


def test_one_estimate_is_kept_and_several_targets_are_kept_apart():
    rng = np.random.default_rng(1)
    mean = rng.normal(size=(5, 4))
    covariance = np.array([random_joint(rng, 1) for _ in range(5)])
    part = np.array([0, 1, 1, 2, 1])
    combined, spread = intersection(mean, covariance, part, 3)
    assert np.allclose(combined[[0, 2]], mean[[0, 3]])
    assert np.allclose(spread[[0, 2]], covariance[[0, 3]])
    alone = intersection(mean[part == 1], covariance[part == 1], np.zeros(3, np.intp), 1)
    assert np.allclose(combined[1], alone[0][0])
    assert np.allclose(spread[1], alone[1][0])


def test_the_same_estimate_twice_is_no_surer_than_once():
    covariance = np.tile(np.diag([0.1, 0.2, 1.0, 2.0]), (2, 1, 1))
    _, spread = intersection(np.ones((2, 4)), covariance, np.zeros(2, np.intp), 1)
    assert np.allclose(spread[0], covariance[0])
