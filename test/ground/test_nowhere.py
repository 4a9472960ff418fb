"""What every mapping says of pixels and places that have no counterpart."""

import numpy as np
import pytest

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import METHODS, grid_from_points, mapping_from_grid

TRUTH = camera()
POINTS = seen_grid(TRUTH, 4.0)
GRID = grid_from_points(
    'cam', [f'{x:g}/{y:g}' for x, y in POINTS], POINTS, TRUTH.image_from_ground(POINTS)
)[0]
MAPPINGS = {method: mapping_from_grid(GRID, SIZE, method) for method in METHODS}


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize(
    'pixel', [(np.nan, np.nan), (np.nan, 300.0), (np.inf, 300.0), (360.0, -3000.0)]
)
def test_a_pixel_without_ground_has_no_position_and_no_covariance(method, pixel):
    position, covariance = MAPPINGS[method].locate([pixel], np.eye(2))
    assert np.isnan(position).all()
    assert np.isnan(covariance).all()


@pytest.mark.parametrize('method', ['fitted', 'cell', 'iterated'])
def test_a_pixel_that_is_none_is_extrapolated(method):
    assert MAPPINGS[method].is_extrapolated([[np.nan, 3.0]]).all()


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('place', [(3.0, -200.0), (np.nan, 3.0)])
def test_a_place_without_pixel_has_no_jacobian_and_no_covariance(method, place):
    mapping = MAPPINGS[method]
    assert np.isnan(mapping.image_from_ground([place])).all()
    assert np.isnan(mapping.image_jacobian([place])).all()
    assert np.isnan(mapping.ground_covariance([place], np.eye(2))).all()


def test_a_place_beyond_the_edge_of_the_lens_has_no_jacobian_and_no_covariance():
    place = [[400.0, 0.0]]
    assert np.isnan(TRUTH.image_from_ground(place)).all()
    assert np.isnan(TRUTH.image_jacobian(place)).all()
    assert np.isnan(TRUTH.ground_covariance(place, np.eye(2))).all()


@pytest.mark.parametrize('method', METHODS)
def test_points_of_another_shape_are_refused(method):
    with pytest.raises(ValueError, match=r'shape \(2, 3\), expected \(n, 2\)'):
        MAPPINGS[method].ground_from_image(np.ones((2, 3)))
    assert MAPPINGS[method].ground_from_image([]).shape == (0, 2)


@pytest.mark.parametrize('method', METHODS)
def test_what_is_outside_the_points_is_believed_less_the_further_it_is(method):
    mapping = MAPPINGS[method]
    centre = GRID.image.mean(axis=(0, 1))
    lowest = GRID.image[..., 1].max()
    pixels = np.column_stack([np.full(3, centre[0]), lowest + np.array([-25.0, 15.0, 40.0])])
    position = mapping.ground_from_image(pixels)
    in_image = mapping.image_covariance(position, mapping.calibration_covariance(position))
    assert mapping.is_extrapolated(pixels).tolist() == [False, True, True]
    assert (np.diff(np.trace(in_image, axis1=1, axis2=2)) > 0.1).all()
