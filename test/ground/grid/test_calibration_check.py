import dataclasses

import numpy as np
import pytest

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    CameraMapping,
    check_grid,
    first_look,
    fit_camera,
    grid_from_points,
)
from mctrack_ros.ground.files.keyed.lens_models import lens_of


def clicked_grid(noise_px=0.3, seed=1, image_size=SIZE):
    x, y = np.meshgrid(np.arange(4), np.arange(3))
    ground = np.column_stack([x.ravel() * 6.0 - 9.0, y.ravel() * 8.0 - 4.0])
    noise = np.random.default_rng(seed).normal(0, noise_px, (12, 2))
    names = [f'{"ABC"[row]}{column}' for row, column in zip(y.ravel(), x.ravel())]
    image = camera().image_from_ground(ground) + noise
    grid = grid_from_points('cam1', names, ground, image)[0]
    return dataclasses.replace(grid, image_size=image_size)


def moved(grid, name, by):
    image = grid.image + (np.array(grid.names) == name)[..., None] * np.array(by)
    return dataclasses.replace(grid, image=image)


@pytest.mark.parametrize('seed', range(3))
def test_careful_clicks_are_accepted(seed):
    check = check_grid(clicked_grid(seed=seed), SIZE)
    assert check.refusal == ''
    assert check.suspicious == check.warnings() == ()
    assert check.rms_px < check.left_out_rms_px < 2.0
    assert 0 < check.deviation_m < 0.2


def test_a_wrong_click_is_named_with_how_far_it_is_off():
    check = check_grid(moved(clicked_grid(), 'B2', (11.0, -8.0)), SIZE)
    assert check.suspicious == ('B2',)
    assert 'do not fit the others: B2' in check.refusal
    (warning,) = check.warnings()
    off = float(warning.split()[3])
    assert warning == f'point B2 is {off:.3g} px off: check it'
    assert off == pytest.approx(np.hypot(11, 8), rel=0.15)


def test_two_wrong_clicks_do_not_hide_one_another():
    grid = moved(moved(clicked_grid(), 'B2', (14.0, 0.0)), 'A1', (0.0, 10.0))
    assert set(check_grid(grid, SIZE).suspicious) == {'A1', 'B2'}


def test_sloppy_clicks_are_refused():
    check = check_grid(clicked_grid(noise_px=2.0), SIZE, 2.0)
    assert 'from where the others put them, expected at most 2 px' in check.refusal


def test_what_gives_no_camera_is_refused_with_the_reason():
    few = clicked_grid()
    few = dataclasses.replace(few, names=few.names[:1], ground=few.ground[:1], image=few.image[:1])
    check = check_grid(few, SIZE)
    assert 'under-determined' in check.refusal
    assert np.isnan(check.rms_px)
    other = dataclasses.replace(clicked_grid(), image_size=(1, 1))
    assert 'for images of 1 x 1 px' in check_grid(other, SIZE).refusal


DOUBLE = (1440, 1152)
CHECKS = [lambda *each: check_grid(*each).refusal, first_look]


@pytest.mark.parametrize('check', CHECKS, ids=['check', 'look'])
def test_a_wrong_image_size_is_guessed(check):
    grid = clicked_grid(image_size=None)
    assert check(grid, SIZE) == ''
    hint = 'they fit images of 720 x 576 px: is the image size 1440 x 1152 px wrong'
    assert hint in check(grid, DOUBLE)


def test_a_wrong_image_size_is_guessed_only_where_the_grid_states_none_and_another_fits():
    grid = clicked_grid(image_size=None)
    small = dataclasses.replace(grid, image=grid.image / 2)
    assert 'they fit images of 360 x 288 px' in first_look(small, SIZE)
    refusal = first_look(dataclasses.replace(small, image_size=SIZE), SIZE)
    assert refusal
    assert 'they fit' not in refusal
    assert 'they fit' not in first_look(moved(grid, 'B2', (11.0, -8.0)), SIZE)


def test_a_first_look_names_what_does_not_fit():
    assert 'do not fit the others: B2' in first_look(
        moved(clicked_grid(), 'B2', (40.0, -30.0)), SIZE
    )
    other = dataclasses.replace(clicked_grid(), image_size=(1, 1))
    assert 'for images of 1 x 1 px' in first_look(other, SIZE)


def grid_of(mapping, spacing):
    ground = seen_grid(mapping, spacing, 30.0)
    noise = np.random.default_rng(1).normal(0, 0.3, ground.shape)
    names = [f'{x:g}:{y:g}' for x, y in ground]
    return grid_from_points('cam1', names, ground, mapping.image_from_ground(ground) + noise)[0]


@pytest.mark.parametrize(
    ('check', 'focal'), [(CHECKS[0], 200.0), (first_look, 200.0), (first_look, 300.0)]
)
def test_a_fisheye_that_no_five_terms_describe_is_refused(check, focal):
    middle = np.array([focal, focal, *np.divide(SIZE, 2)])
    intrinsics, terms, _ = lens_of('equidistant', middle, [0.0] * 4, SIZE)
    inner = dataclasses.replace(camera().camera, intrinsics=intrinsics, distortion=terms)
    grid = dataclasses.replace(grid_of(CameraMapping(inner, SIZE), 8.0), image_size=SIZE)
    assert check(grid, SIZE)


@pytest.mark.parametrize('check', CHECKS, ids=['check', 'look'])
@pytest.mark.parametrize(('off_px', 'reason'), [(20.0, ''), (150.0, 'principal point x would be')])
def test_a_cropped_image_is_told_from_a_principal_point_as_lenses_have_it(check, off_px, reason):
    inner = camera().camera
    moved = dataclasses.replace(inner, intrinsics=inner.intrinsics + np.array([0, 0, off_px, 0]))
    grid = dataclasses.replace(grid_of(CameraMapping(moved, SIZE), 8.0), image_size=SIZE)
    refusal = check(grid, SIZE)
    assert reason in refusal
    assert bool(refusal) == bool(reason)


def refitted(grid, kept):
    """Fit again without each point in turn, from nothing: misses in px and in deviations."""
    _, ground, image = grid.named_points()
    found = []
    for index in range(len(ground)):
        others = kept & (np.arange(len(ground)) != index)
        fit = fit_camera(ground[others], image[others], SIZE)
        place = ground[index][None]
        away = image[index] - fit.mapping.image_from_ground(place)[0]
        spread = fit.mapping.calibration_covariance(place)
        expected = fit.mapping.image_covariance(place, spread)[0] + fit.noise_px**2 * np.eye(2)
        found.append((np.linalg.norm(away), np.sqrt(away @ np.linalg.inv(expected) @ away)))
    return np.array(found).T


WRONG = [{}, {'B2': (11.0, -8.0)}, {'B2': (14.0, 0.0), 'A1': (0.0, 40.0)}, {'C3': (90.0, 60.0)}]


@pytest.mark.parametrize(('seed', 'wrong'), enumerate(WRONG), ids=['careful', 'one', 'two', 'far'])
def test_errors_are_those_of_fits_from_nothing(seed, wrong):
    grid = clicked_grid(seed=seed)
    for name, by in wrong.items():
        grid = moved(grid, name, by)
    check = check_grid(grid, SIZE)
    kept = ~np.isin(check.names, check.suspicious)
    missed, score = refitted(grid, kept)
    np.testing.assert_allclose(check.left_out_px, missed, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(check.score, score, rtol=1e-3, atol=1e-3)


def test_the_fewest_points_leave_nothing_to_check_by():
    x, y = np.meshgrid([-9.0, 0.0, 9.0], [-4.0, 12.0])
    ground = np.column_stack([x.ravel(), y.ravel()])
    image = camera().image_from_ground(ground)
    grid = grid_from_points('cam1', list('ABCDEF'), ground, image)[0]
    check = check_grid(grid, SIZE)
    assert np.isnan(check.left_out_px).all()
    assert 'left out' in check.refusal
