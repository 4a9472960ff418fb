"""The baselines, and what is measured beside belief propagation."""

import numpy as np
import pytest

from mctrack_experiments.papers.belief.comparison import played
from mctrack_experiments.papers.belief.condensation import Estimate, best_view, central
from mctrack_experiments.papers.belief.scenes import Kind, scripted

ONE = Estimate(
    np.array([[0.0, 0.0], [4.0, 4.0], [np.nan, np.nan]]),
    np.stack([np.diag([1.0, 4.0]), np.eye(2), np.eye(2)]),
    np.array([-1.0, -5.0, -np.inf]),
)
OTHER = Estimate(
    np.array([[1.0, 1.0], [np.nan, np.nan], [np.nan, np.nan]]),
    np.stack([np.diag([1.0, 1.0]), np.eye(2), np.eye(2)]),
    np.array([-0.5, -np.inf, -np.inf]),
)


def test_centralised_fusion_weighs_by_covariance():
    np.testing.assert_allclose(
        central([ONE, OTHER]), [[0.5, 0.8], [4.0, 4.0], [np.nan, np.nan]], equal_nan=True
    )


def test_the_best_view_is_that_of_the_likelier_image():
    np.testing.assert_allclose(
        best_view([ONE, OTHER]), [[1.0, 1.0], [4.0, 4.0], [np.nan, np.nan]], equal_nan=True
    )


@pytest.mark.parametrize('moving', [False, True], ids=['static', 'ptz'])
def test_every_occlusion_is_judged_for_every_method(moving):
    outcome = played(scripted(3, moving, rate_hz=5.0))
    assert set(outcome.survived) == {'belief', 'central', 'best_view', 'condensation'}
    for name, each in outcome.survived.items():
        assert {kind: len(values) for kind, values in each.items()} == {
            kind: 10 if name == 'condensation' else 5 for kind in Kind
        }
    assert outcome.entropy.shape == (15, 2)
    assert np.isfinite(outcome.entropy).all()
    assert sum(values.sum() for values in outcome.survived['belief'].values()) > 0
