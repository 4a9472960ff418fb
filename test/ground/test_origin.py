"""Far coordinates, as national grids have them, give what the same scene gives near zero."""

import dataclasses

import numpy as np
import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    FORMATS,
    METHODS,
    CalibrationError,
    Camera,
    CameraMapping,
    ProjectiveMapping,
    check_grid,
    fit_camera,
    grid_flaws,
    grid_from_points,
    mapping_from_grid,
    read_calibration,
    read_grid,
    write_calibration,
    write_grid,
)
from mctrack_ros.ground.coverage.coverage import CoverageConfig, coverage_of
from mctrack_ros.ground.coverage.field_of_view import seen_ground
from mctrack_ros.ground.coverage.view import View
from mctrack_ros.ground.grid.cells import CellMapping, Cells
from mctrack_ros.ground.homography.fit import fit_homography
from mctrack_ros.ground.origin import local_origin

OFFSETS = [(389000.0, 5820000.0), (389123.4, 5820456.7), (2e6, 2e6), (1e7, 1e7), (-1e7, 640.0)]
SOME = OFFSETS[1:4:2]
"""Where each costs much."""
STRAIGHT = (0, 0, 0, 0, 0)
MM = 1e-3


def clicked_grid(offset=(0.0, 0.0), distortion=(-0.2, 0, 0, 0, 0)):
    """Return the grid of a camera, clicked with noise, its ground moved by an offset, m."""
    mapping = camera(distortion=distortion)
    points = seen_grid(mapping, 8.0, 40.0)
    noise = np.random.default_rng(4).normal(0, 0.5, points.shape)
    pixel = mapping.image_from_ground(points) + noise
    names = [f'p{index}' for index in range(len(points))]
    return grid_from_points('cam', names, points + offset, pixel)[0]


def assert_same(mapping, near, offset):
    """Hold a mapping against that of the same scene near zero."""
    pixel = np.array([[360.0, 300.0], [90.0, 400.0], [640.0, 500.0], [355.0, 250.0]])
    noise = np.array([[1.0, 0.2], [0.2, 2.0]])
    position, covariance = mapping.locate(pixel, noise)
    expected, spread = near.locate(pixel, noise)
    np.testing.assert_allclose(position - offset, expected, rtol=0, atol=MM)
    np.testing.assert_allclose(covariance, spread, rtol=0.01, atol=1e-6)
    place = expected + offset
    for seen, wanted in (
        (mapping.ground_from_image(pixel) - offset, near.ground_from_image(pixel)),
        (mapping.camera_position[:2] - offset, near.camera_position[:2]),
        (mapping.camera_position[2], near.camera_position[2]),
    ):
        np.testing.assert_allclose(seen, wanted, rtol=0, atol=MM)
    for height in (0.0, 1.75):
        shown = near.image_from_ground(expected, height)
        np.testing.assert_allclose(
            mapping.image_from_ground(place, height), shown, rtol=0, atol=1e-3
        )
    slopes = near.image_jacobian(expected)
    np.testing.assert_allclose(mapping.image_jacobian(place), slopes, rtol=1e-3, atol=1e-3)
    added = near.calibration_covariance(expected)
    np.testing.assert_allclose(mapping.calibration_covariance(place), added, rtol=0.01, atol=1e-6)
    both = near.ground_covariance(expected, noise)
    np.testing.assert_allclose(mapping.ground_covariance(place, noise), both, rtol=0.01, atol=1e-6)
    assert mapping.is_extrapolated(pixel).tolist() == near.is_extrapolated(pixel).tolist()


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('method', METHODS)
def test_every_method_maps_far_points_as_near_ones(method, offset):
    near = mapping_from_grid(clicked_grid(), SIZE, method)
    assert_same(mapping_from_grid(clicked_grid(offset), SIZE, method), near, offset)


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('method', METHODS)
def test_every_mapping_moves_with_its_ground(method, offset):
    near = mapping_from_grid(clicked_grid(), SIZE, method)
    assert_same(near.moved(offset), near, offset)
    back = mapping_from_grid(clicked_grid(offset), SIZE, method).moved(-np.array(offset))
    assert_same(back, near, (0.0, 0.0))


@settings(max_examples=25, deadline=None)
@given(
    st.floats(-1e7, 1e7), st.floats(-1e7, 1e7), st.sampled_from(METHODS), st.integers(0, 2**32 - 1)
)
@example(8645558.0, 0.0, 'fitted', 0)
@example(73539.58401157893, 5068930.771678103, 'fitted', 0)
def test_a_place_and_back_is_the_place_wherever_the_site_is(x, y, method, seed):
    mapping = mapping_from_grid(clicked_grid((x, y)), SIZE, method)
    inside = np.random.default_rng(seed).uniform((-5, -8), (5, 12), (5, 2))  # within the grid
    back = mapping.ground_from_image(mapping.image_from_ground(inside + np.array([x, y])))
    np.testing.assert_allclose(back - (x, y), inside, atol=0.5 if method == 'iterated' else MM)


@pytest.mark.parametrize('offset', OFFSETS)
def test_a_camera_fitted_to_far_points_stands_and_is_as_sure_as_near(offset):
    grid, far = clicked_grid(), clicked_grid(offset)
    fit, moved = fit_camera(*grid.points(), SIZE), fit_camera(*far.points(), SIZE)
    np.testing.assert_allclose(
        moved.mapping.camera.position - [*offset, 0], fit.mapping.camera.position, atol=MM
    )
    assert moved.rms_px == pytest.approx(fit.rms_px, rel=1e-3)
    assert moved.noise_px == fit.noise_px
    np.testing.assert_array_equal(moved.ground, far.points()[0])
    again = fit_camera(*far.points(), SIZE, start=moved.mapping.camera)
    np.testing.assert_allclose(
        again.mapping.camera_position, moved.mapping.camera_position, atol=MM
    )


def test_covariance_and_derivatives_of_a_moved_camera_belong_together():
    mapping, by = fit_camera(*clicked_grid().points(), SIZE).mapping, np.array([300.0, -200.0])
    moved, place = mapping.moved(by), np.array([[1.0, 2.0], [-3.0, 5.0]])
    wanted, found = (
        slopes @ camera.covariance @ slopes.swapaxes(1, 2)
        for slopes, camera in (
            (mapping.parameter_jacobian(place), mapping.camera),
            (moved.parameter_jacobian(place + by), moved.camera),
        )
    )
    np.testing.assert_allclose(found, wanted, rtol=1e-4)
    alone = CameraMapping(moved.camera, SIZE)
    np.testing.assert_allclose(
        alone.calibration_covariance(place + by),
        CameraMapping(mapping.camera, SIZE).calibration_covariance(place),
        rtol=1e-4,
    )


@pytest.mark.parametrize('offset', SOME)
def test_a_check_of_far_points_comes_back_with_the_same_verdict(offset):
    near, far = (check_grid(clicked_grid(each), SIZE) for each in ((0.0, 0.0), offset))
    assert (far.refusal, far.suspicious) == (near.refusal, near.suspicious) == ('', ())
    np.testing.assert_allclose(far.left_out_px, near.left_out_px, atol=1e-3)
    assert far.deviation_m == pytest.approx(near.deviation_m, rel=0.01)


@pytest.mark.parametrize('offset', SOME)
def test_a_wrong_far_point_is_named(offset):
    grid = clicked_grid(offset)
    image = np.where(
        (grid.ground == grid.ground[5, 0]).all(axis=2)[..., None], grid.image + 12.0, grid.image
    )
    wrong = dataclasses.replace(grid, image=image, image_size=SIZE)
    assert check_grid(wrong, SIZE).suspicious == (grid.names[5][0],)


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('side', [0.1, 1.0])
def test_small_far_cells_are_no_lines(tmp_path, offset, side):
    mapping = camera((0, -2, 1.5), (0, 1, 0))
    axis = side * np.arange(-2, 3) / 2
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    names = [f'p{index}' for index in range(len(points))]
    pixel = mapping.image_from_ground(points)
    grid = grid_from_points('cam', names, points + offset, pixel)[0]
    assert list(grid_flaws(grid)) == []
    write_grid(grid, tmp_path / 'cam.xml')
    np.testing.assert_array_equal(read_grid(tmp_path / 'cam.xml').ground, grid.ground)


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('to', list(FORMATS))
def test_every_format_keeps_a_far_camera(tmp_path, to, offset):
    near = camera(distortion=STRAIGHT if 'image' in to else (-0.03, 0, 0, 0, 0))
    path = tmp_path / ('cam.xml' if to in ('grid', 'tsai', 'opencv') else 'cam.yaml')
    write_calibration(near.moved(offset), path, to, 'cam')
    read = read_calibration(path, SIZE)
    pixel = np.array([[360.0, 300.0], [90.0, 400.0], [640.0, 500.0]])
    # a grid and a Tsai lens are near the camera, within parts of a pixel
    write_calibration(near, tmp_path / f'near_{path.name}', to, 'cam')
    same = read_calibration(tmp_path / f'near_{path.name}', SIZE)
    np.testing.assert_allclose(
        read.ground_from_image(pixel) - offset, same.ground_from_image(pixel), atol=2 * MM
    )
    np.testing.assert_allclose(
        read.camera_position - [*offset, 0], same.camera_position, atol=5 * MM
    )


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('name', ['image_from_ground', 'ground_from_image', 'image_from_world'])
@pytest.mark.parametrize('unit', [1.0, 100.0])
def test_matrices_of_far_ground_are_read(tmp_path, name, offset, unit):
    near = ProjectiveMapping(camera(distortion=STRAIGHT).camera.image_from_world, SIZE)
    far = near.moved(offset)
    matrix = {
        'image_from_ground': far.image_from_ground_homography,
        'ground_from_image': far.ground_from_image_homography,
        'image_from_world': far.image_from_world,
    }[name].copy()
    if name == 'ground_from_image':
        matrix[:2] *= unit
    else:
        matrix[:, :-1] /= unit
    (tmp_path / 'cam.yaml').write_text(yaml.safe_dump({name: matrix.tolist()}))
    length = {1.0: 'm', 100.0: 'cm'}[unit]
    assert_same(read_calibration(tmp_path / 'cam.yaml', SIZE, unit=length), near, offset)


@pytest.mark.parametrize('offset', OFFSETS)
def test_a_singular_far_homography_is_refused(offset):
    flat = np.array([[3.0, 1.0], [1.0, 2.0], [0.1, 0.2]])
    singular = np.column_stack([flat, -flat @ np.array(offset)])
    with pytest.raises(ValueError, match='singular'):
        ProjectiveMapping.from_homography(singular, SIZE)


def test_a_pose_with_too_few_digits_for_its_distance_is_refused(tmp_path):
    far = camera().moved((389000.0, 5820000.0)).camera
    rounded = np.round(far.rotation, 6)
    with pytest.raises(ValueError, match='too few digits for a camera so far from the origin'):
        Camera(far.intrinsics, far.distortion, rounded, far.translation)
    rows = [f'[{", ".join(f"{value:.6f}" for value in row)}]' for row in far.rotation]
    (tmp_path / 'cam.yml').write_text(
        '%YAML:1.0\n---\n'
        'camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n'
        '   data: [650., 0., 360., 0., 650., 288., 0., 0., 1.]\n'
        'distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n'
        '   data: [-0.2, 0., 0., 0., 0.]\n'
        f'R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: '
        f'[{", ".join(row.strip("[]") for row in rows)}]\n'
        f'T: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: '
        f'{far.translation.tolist()}\n'
    )
    with pytest.raises(CalibrationError, match='state the pose about a point near by'):
        read_calibration(tmp_path / 'cam.yml', SIZE)


@pytest.mark.parametrize('offset', OFFSETS)
def test_a_homography_of_far_points_has_its_own_frame(offset):
    ground, image = clicked_grid(offset, STRAIGHT).points()
    fit = fit_homography(ground, image, 0.5)
    places = (ground - ground.mean(axis=0)) * fit.frame[0, 0]
    seen = np.column_stack([places, np.ones(len(places))]) @ fit.matrix.T
    assert np.abs(seen[:, :2] / seen[:, 2:] - image).max() < 3.0


@pytest.mark.parametrize('offset', OFFSETS)
def test_cells_far_away_know_what_is_in_them(offset):
    near, far = Cells.of(clicked_grid()), Cells.of(clicked_grid(offset))
    middle = near.ground.mean(axis=1)
    expected = CellMapping(near, SIZE).image_from_ground(middle)
    seen = CellMapping(far, SIZE).image_from_ground(middle + offset)
    np.testing.assert_allclose(seen, expected, atol=1e-3)


@pytest.mark.parametrize('offset', SOME)
def test_what_a_far_camera_sees_and_covers_is_the_same(offset):
    views = []
    for by in ((0.0, 0.0), offset):
        mapping = fit_camera(*clicked_grid(by).points(), SIZE).mapping
        field = seen_ground(mapping, 60.0)
        views.append(coverage_of({'cam': View(field, mapping)}, None, CoverageConfig(cell=2.0)))
    near, far = views
    assert far.area.area == pytest.approx(near.area.area, rel=1e-5)
    assert far.fields[0].area == pytest.approx(near.fields[0].area, rel=1e-5)
    np.testing.assert_allclose(far.feet - offset, near.feet, atol=MM)
    assert np.nanmedian(far.raster.fused) == pytest.approx(np.nanmedian(near.raster.fused), 0.01)


def test_local_origins_are_whole_kilometres_near_the_points():
    points = np.array([[389012.5, 5819740.0], [389030.0, 5819790.0], [np.nan, 0.0]])
    assert local_origin(points).tolist() == [389000.0, 5820000.0]
    assert local_origin([[120.0, -480.0]]).tolist() == [0.0, 0.0]
    assert local_origin(np.empty((0, 2))).tolist() == [0.0, 0.0]
    assert local_origin([[np.inf, 1.0]]).tolist() == [0.0, 0.0]
