"""Pixels outside the points of a calibration are believed less."""

import numpy as np

from mctrack_ros.ground.support import OUTSIDE_SHARE, cell_doubts, doubts, hull_of


def slow_distance(corners, pixel):
    """Return how far pixels are from a polygon's border, by many points along it, px."""
    share = np.linspace(0, 1, 2001)[:, None, None]
    border = (corners + share * (np.roll(corners, -1, axis=0) - corners)).reshape(-1, 2)
    return np.array([np.linalg.norm(border - one, axis=1).min() for one in pixel])


def test_the_farther_outside_the_points_the_less_a_pixel_is_believed():
    rng = np.random.default_rng(0)
    points = rng.uniform(100, 300, (12, 2))
    corners, pixel = hull_of(points), rng.uniform(0, 400, (100, 2))
    weights = rng.dirichlet(np.ones(12), 40)
    inside, none = weights @ points, np.array([[np.nan, 0.0], [0.0, np.inf]])
    np.testing.assert_array_equal(doubts(corners, inside), 0.0)
    np.testing.assert_array_equal(
        doubts(corners, points.astype(np.float32).astype(float)) < 1e-9, True
    )
    np.testing.assert_array_equal(doubts(corners, none), np.inf)
    found = doubts(corners, pixel)
    far = found > 0
    np.testing.assert_allclose(
        np.sqrt(found[far]) / OUTSIDE_SHARE, slow_distance(corners, pixel[far]), atol=0.05
    )
    middle = corners.mean(axis=0)
    assert not far[np.linalg.norm(pixel - middle, axis=1) < 20].any()
    both = np.stack([corners[::-1], corners + 500])
    cell = np.arange(100) % 2
    expected = np.where(cell == 0, found, doubts(both[1], pixel))
    np.testing.assert_allclose(cell_doubts(both, cell, pixel), expected)


def test_without_points_nothing_is_known_to_be_outside():
    assert hull_of(None).shape == (0, 2)
    np.testing.assert_array_equal(doubts(hull_of(None), np.ones((1, 2))), 0.0)
