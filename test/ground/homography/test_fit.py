"""Homographies from clicked points, and how uncertain they are."""

import numpy as np
import pytest

from mctrack_ros.ground.homography.covariance import add_spread, by_entries, spread_terms
from mctrack_ros.ground.homography.fit import fit_homography, start_homography

TRUE = np.array([[40.0, -8.0, 320.0], [3.0, 30.0, 260.0], [0.004, 0.02, 1.0]])
PLACES = np.stack(np.meshgrid(np.linspace(-6, 6, 5), np.linspace(0, 12, 5)), -1).reshape(-1, 2)


def mapped(matrix, places):
    points = np.column_stack([places, np.ones(len(places))]) @ matrix.T
    return points[:, :2] / points[:, 2:]


def in_metres(fit):
    matrix = fit.matrix @ fit.frame
    return matrix / matrix[2, 2]


def test_derivatives_by_the_entries_agree_with_differences():
    step = 1e-6
    found = by_entries(TRUE, PLACES)
    for entry in range(9):
        change = step * np.eye(9)[entry].reshape(3, 3)
        slope = (mapped(TRUE + change, PLACES) - mapped(TRUE - change, PLACES)) / (2 * step)
        np.testing.assert_allclose(found[:, :, entry], slope, rtol=1e-6, atol=1e-4)


def test_the_spread_of_pixels_is_that_of_the_entries_carried_on():
    rng = np.random.default_rng(0)
    root = rng.normal(0, 1, (9, 9))
    covariance = root @ root.T
    terms = spread_terms(covariance)
    for place, slopes in zip(PLACES, by_entries(TRUE, PLACES)):
        spread = np.eye(2)
        add_spread(TRUE, terms, *place, spread)
        np.testing.assert_allclose(spread - np.eye(2), slopes @ covariance @ slopes.T, rtol=1e-9)


def test_exact_clicks_give_the_homography_and_nothing_left_over():
    fit = fit_homography(PLACES, mapped(TRUE, PLACES), 1.0)
    np.testing.assert_allclose(in_metres(fit), TRUE, atol=1e-5)
    assert fit.misfit_px2 == 0.0
    in_frame = PLACES @ fit.frame[:2, :2].T + fit.frame[:2, 2]
    np.testing.assert_allclose(in_frame.mean(axis=0), 0.0, atol=1e-12)
    assert np.abs(in_frame).max() == pytest.approx(1.0)


@pytest.mark.parametrize('stated_px', [0.7, 0.1])
def test_the_pixel_of_a_place_is_as_uncertain_as_it_says(stated_px):
    """
    Over many sets of clicks, of .7 px; what is more than stated is a misfit, too.

    The mean square of two components by their covariance is 2, and a misfit is chi² by freedom.
    """
    rng, noise_px = np.random.default_rng(1), 0.7
    place = np.array([[3.0, 15.0]])
    errors, misfits = [], []
    for _ in range(150):
        image = mapped(TRUE, PLACES) + rng.normal(0, noise_px, PLACES.shape)
        fit = fit_homography(PLACES, image, stated_px)
        at = place * fit.frame[0, 0] + fit.frame[:2, 2]
        spread = np.zeros((2, 2))
        add_spread(fit.matrix, fit.terms, *at[0], spread)
        gap = (mapped(fit.matrix, at) - mapped(TRUE, place))[0]
        errors.append(gap @ np.linalg.solve(spread, gap))
        misfits.append(fit.misfit_px2)
    assert 1.5 < np.mean(errors) < 2.4
    if stated_px < noise_px:
        assert np.mean(misfits) == pytest.approx(noise_px**2 - stated_px**2, rel=0.1)


def test_a_wild_click_counts_for_next_to_nothing():
    rng = np.random.default_rng(2)
    image = mapped(TRUE, PLACES) + rng.normal(0, 0.3, PLACES.shape)
    clean = mapped(in_metres(fit_homography(PLACES[1:], image[1:], 0.3)), PLACES)
    image[0] += [60.0, -40.0]
    wild = mapped(in_metres(fit_homography(PLACES, image, 0.3)), PLACES)
    np.testing.assert_allclose(wild, clean, atol=0.1)


@pytest.mark.parametrize(
    ('places', 'reason'), [(PLACES[:3], '3 points'), (PLACES[:5], 'lie on a line')]
)
def test_points_that_fix_no_homography_are_refused(places, reason):
    with pytest.raises(ValueError, match=reason):
        start_homography(places, mapped(TRUE, places))
