import numpy as np
import pytest

from mctrack_experiments.scenarios.consistency import (
    KINDS,
    error_figures,
    map_figures,
    modelled,
    nees_figures,
)
from mctrack_ros.fusion import JointConfig


def drawn(seed, told=1.0, rows=400):
    """Errors of unit variance, told to be so many times as large."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0, 10, (rows, 4))
    return truth, rng.normal(0, 1, (rows, 4)), np.tile(told**2 * np.eye(4), (rows, 1, 1))


def test_errors_as_large_as_told_lie_in_the_band():
    figures = nees_figures('x', [drawn(seed) for seed in range(20)], 4)
    assert figures['x.nees_low'] < figures['x.nees'] < figures['x.nees_high']
    assert figures['x.nees_inside'] == pytest.approx(0.95, abs=0.05)


def test_tracks_that_are_too_sure_lie_above_it():
    figures = nees_figures('x', [drawn(seed, 0.5) for seed in range(20)], 2)
    assert figures['x.nees'] == pytest.approx(4.0, rel=0.1)
    assert figures['x.nees_inside'] == 0.0


def test_the_map_tells_how_measured_and_told_errors_compare():
    figures = map_figures('x', [drawn(seed, 2.0) for seed in range(20)])
    assert figures['x.map.cells'] == 4
    assert figures['x.map.ratio'] == pytest.approx(0.5, rel=0.05)
    assert figures['x.map.within_25'] == 0.0


def test_a_target_that_moves_as_the_filter_assumes_is_where_it_is_told_to_be():
    figures = nees_figures('x', [modelled(seed, JointConfig()) for seed in (1, 2)], 4)
    assert 0.5 < figures['x.nees'] < 1.6


def test_errors_stand_beside_what_is_told_of_them():
    figures = error_figures('x', [drawn(seed, 2.0) for seed in range(20)])
    assert figures['x.error_m'] == pytest.approx(np.sqrt(2), rel=0.02)
    assert figures['x.velocity_error_ratio'] == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize('kind', KINDS)
def test_everybody_is_followed_to_the_end(kind):
    truth, error, _ = KINDS[kind](3, JointConfig())
    assert len(truth) >= 100
    assert np.linalg.norm(error[-1, :2]) < 1.0
