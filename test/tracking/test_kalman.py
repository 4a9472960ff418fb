import numpy as np
import pytest
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.tracking import kalman


def states(count, seed):
    rng = np.random.default_rng(seed)
    spread = rng.normal(size=(count, 4, 4))
    return rng.normal(size=(count, 4)), spread @ spread.swapaxes(1, 2) + 0.1 * np.eye(4)


def oracle(mean, covariance):
    single = KalmanFilter(dim_x=4, dim_z=2)
    single.x, single.P = mean.copy(), covariance.copy()
    return single


@pytest.mark.parametrize('seconds', [0.0, 0.04, 0.5])
def test_prediction_agrees_with_filterpy(seconds):
    mean, covariance = states(6, 1)
    moved, spread = kalman.predict(mean, covariance, seconds, 2.5)
    for index in range(6):
        single = oracle(mean[index], covariance[index])
        single.F = kalman.transition_matrix(seconds)
        single.Q = Q_continuous_white_noise(
            2, dt=seconds, spectral_density=2.5, block_size=2, order_by_dim=False
        )
        single.predict()
        np.testing.assert_allclose(moved[index], single.x)
        np.testing.assert_allclose(spread[index], single.P)


@pytest.mark.parametrize('seconds', [0.0, -0.03])
def test_update_agrees_with_filterpy(seconds):
    mean, covariance = states(6, 2)
    rng = np.random.default_rng(3)
    measured, noise = (
        rng.normal(size=(6, 2)),
        np.tile(np.array([[0.3, 0.1], [0.1, 0.2]]), (6, 1, 1)),
    )
    matrix = kalman.position_matrix(seconds)
    updated, spread = kalman.update(mean, covariance, measured - mean @ matrix.T, noise, matrix)
    for index in range(6):
        single = oracle(mean[index], covariance[index])
        single.H, single.R = matrix, noise[index]
        single.update(measured[index])
        np.testing.assert_allclose(updated[index], single.x)
        np.testing.assert_allclose(spread[index], single.P, atol=1e-12)


@settings(deadline=None)
@given(seed=st.integers(0, 10**6), seconds=st.floats(0, 5), sigma=st.floats(1e-3, 1e3))
def test_covariances_stay_positive_definite(seed, seconds, sigma):
    mean, covariance = states(3, seed)
    noise = np.tile(sigma**2 * np.eye(2), (3, 1, 1))
    for _ in range(20):
        mean, covariance = kalman.predict(mean, covariance, seconds, 1.0)
        mean, covariance = kalman.update(
            mean, covariance, np.ones((3, 2)), noise, kalman.position_matrix()
        )
        assert (np.linalg.eigvalsh(covariance) > 0).all()
        np.testing.assert_array_equal(covariance, covariance.swapaxes(1, 2))


def test_inverse_agrees_with_numpy():
    matrix = np.random.default_rng(4).normal(size=(5, 2, 2))
    np.testing.assert_allclose(kalman.inverse(matrix), np.linalg.inv(matrix))
