import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    GridError,
    TransformationGrid,
    grid_from_points,
)
from mctrack_ros.ground.grid.cells import CellMapping, Cells
from mctrack_ros.ground.grid.iterated import IteratedMapping
from mctrack_ros.ground.support import OUTSIDE_SHARE


def grid_of(mapping, spacing=4.0):
    points = seen_grid(mapping, spacing)
    names = [f'{x:g}/{y:g}' for x, y in points]
    return grid_from_points('cam', names, points, mapping.image_from_ground(points))[0]


def middle(count):
    """Return points in the middle of the grid, (count, 2) m."""
    return np.random.default_rng(1).uniform((-6, 6), (6, 18), (count, 2))


STRAIGHT = camera(distortion=(0, 0, 0, 0, 0))
CELLS = Cells.of(grid_of(STRAIGHT))
METHODS = [CellMapping(CELLS, SIZE), IteratedMapping(CELLS, SIZE, 0.0)]
STOPPING = IteratedMapping(CELLS, SIZE)


@pytest.mark.parametrize('mapping', METHODS)
def test_corners_are_mapped_to_themselves(mapping):
    ground, image = CELLS.ground.reshape(-1, 2), CELLS.image.reshape(-1, 2)
    np.testing.assert_allclose(mapping.ground_from_image(image), ground, atol=1e-5)
    np.testing.assert_allclose(mapping.image_from_ground(ground), image, atol=1e-5)
    assert not mapping.is_extrapolated(CELLS.image.mean(axis=1)).any()


@settings(max_examples=60, deadline=None)
@given(
    share=st.tuples(st.floats(0, 1), st.floats(0, 1)), cell=st.integers(0, len(CELLS.ground) - 1)
)
def test_no_method_moves_a_point_to_another_cell(share, cell):
    weights = np.outer([1 - share[1], share[1]], [1 - share[0], share[0]]).ravel()[[0, 1, 3, 2]]
    pixel = (weights[:, None] * CELLS.image[cell]).sum(axis=0)[None]
    low, high = CELLS.ground[cell].min(axis=0), CELLS.ground[cell].max(axis=0)
    for mapping in METHODS:
        place = mapping.ground_from_image(pixel)
        assert (place >= low - 1e-6).all()
        assert (place <= high + 1e-6).all()


@settings(max_examples=60, deadline=None)
@given(
    share=st.tuples(st.floats(0, 1), st.floats(0, 1)), cell=st.integers(0, len(CELLS.ground) - 1)
)
def test_the_paper_s_stop_leaves_a_point_in_the_cell_that_it_was_found_in(share, cell):
    weights = np.outer([1 - share[1], share[1]], [1 - share[0], share[0]]).ravel()[[0, 1, 3, 2]]
    pixel = (weights[:, None] * CELLS.image[cell]).sum(axis=0)[None]
    found = CELLS.in_image(pixel)[0][0]  # on an edge it may be the neighbour
    place = STOPPING.ground_from_image(pixel)
    assert (place >= CELLS.ground[found].min(axis=0) - 1e-6).all()
    assert (place <= CELLS.ground[found].max(axis=0) + 1e-6).all()


def test_a_cell_of_its_own_is_exact_without_distortion():
    points = middle(200)
    place = METHODS[0].ground_from_image(STRAIGHT.image_from_ground(points))
    np.testing.assert_allclose(place, points, atol=1e-6)


@pytest.mark.parametrize('mapping', METHODS)
def test_derivatives_agree_with_differences(mapping):
    points, step = middle(50), 1e-6
    for axis in range(2):
        moved = np.eye(2)[axis] * step
        expected = (
            mapping.image_from_ground(points + moved) - mapping.image_from_ground(points - moved)
        ) / (2 * step)
        found = mapping.image_jacobian(points)[:, :, axis]
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize('mapping', METHODS)
def test_ground_to_image_and_back(mapping):
    points = middle(50)
    back = mapping.ground_from_image(mapping.image_from_ground(points))
    np.testing.assert_allclose(back, points, atol=1e-5)


def test_who_lies_beside_somebody_upright_is_where_he_would_be_alone():
    mapping = METHODS[0]
    places = np.array([[0.0, 12.0], [3.0, 10.0]])
    both = mapping.image_from_ground(places, np.array([0.0, 1.8]))
    np.testing.assert_allclose(both[:1], mapping.image_from_ground(places[:1]), atol=1e-9)
    np.testing.assert_allclose(both[1:], mapping.image_from_ground(places[1:], 1.8), atol=1e-9)


@pytest.mark.parametrize(('mapping', 'off'), zip(METHODS, (1e-6, 1.0)))
def test_a_point_beside_the_grid_is_extrapolated_from_the_nearest_cell(mapping, off):
    near = CELLS.ground[:, 0][CELLS.ground[:, 0, 1] == CELLS.ground[..., 1].min()]
    place = near + np.array([1.0, -0.5])
    pixel = STRAIGHT.image_from_ground(place)
    assert mapping.is_extrapolated(pixel).all()
    assert not mapping.is_extrapolated(STRAIGHT.image_from_ground(near + 1.0)).any()
    np.testing.assert_allclose(mapping.ground_from_image(pixel), place, atol=off)


def test_beside_the_grid_a_pixel_is_believed_less_in_both_directions():
    """By a share of its distance from the nearest cell; within the grid as it is seen."""
    mapping, noise = METHODS[0], np.array([[2.0, 0.5], [0.5, 1.0]])
    outline = shapely.union_all([shapely.Polygon(corners) for corners in CELLS.image])
    middle = CELLS.image.mean(axis=(0, 1))
    pixel = middle + np.array([[0.0, 0.0], [-380, 30], [400, 80], [20, 330], [-300, 300]])
    away = shapely.distance(outline, shapely.points(pixel))
    assert (away > 0).tolist() == [False, True, True, True, True]
    _, covariance = mapping.locate(pixel, noise)
    slopes, step = np.empty((len(pixel), 2, 2)), 1e-4
    for axis in range(2):
        moved = np.eye(2)[axis] * step
        ahead, behind = (mapping.ground_from_image(pixel + sign * moved) for sign in (1, -1))
        slopes[:, :, axis] = (ahead - behind) / (2 * step)
    seen = noise + ((OUTSIDE_SHARE * away) ** 2)[:, None, None] * np.eye(2)
    expected = slopes @ seen @ slopes.swapaxes(1, 2)
    np.testing.assert_allclose(covariance, expected, rtol=1e-4)


def test_the_paper_stops_a_pixel_away():
    points = middle(200)
    pixel = STRAIGHT.image_from_ground(points)
    stopped = STOPPING.ground_from_image(pixel)
    misses = METHODS[1].image_from_ground(stopped) - METHODS[1].image_from_ground(
        METHODS[1].ground_from_image(pixel)
    )
    assert 0.1 < np.abs(misses).max() < 4.0


def test_points_of_incomplete_cells_are_ignored_and_listed():
    names = ['a', 'b', 'c', 'd', 'e', 'f']
    ground = np.array([[0, 0], [8, 0], [8, 8], [0, 8], [16, 0], [0, 16.0]])
    grid, ignored = grid_from_points('cam', names, ground, ground * 10 + 5)
    assert grid.names == (('a', 'b', 'c', 'd'),)
    assert ignored == ('e', 'f')
    with pytest.raises(GridError, match='no complete cell'):
        grid_from_points('cam', names[:3], ground[:3], ground[:3])


@pytest.mark.parametrize(
    ('ground', 'reason'),
    [
        ([[0, 0], [8, 0], [8, 8], [1, 8]], 'no rectangle along the axes'),
        ([[0, 0], [8, 0], [8, 0], [0, 8]], 'no rectangle along the axes'),
    ],
)
def test_cells_that_are_no_rectangles_are_refused(ground, reason):
    image = np.array([[0, 0], [80, 0], [80, 80], [0, 80.0]])
    grid = TransformationGrid('cam', (tuple('abcd'),), np.array([ground], float), image[None])
    with pytest.raises(GridError, match=reason):
        Cells.of(grid)


def test_swapped_corners_are_refused_by_name():
    ground = np.array([[0, 0], [8, 0], [8, 8], [0, 8.0]])
    image = ground[[0, 2, 1, 3]] * 10
    with pytest.raises(GridError, match='are two of a, b, c, d swapped'):
        Cells.of(TransformationGrid('cam', (tuple('abcd'),), ground[None], image[None]))


@pytest.mark.parametrize('make', [CellMapping])
def test_the_corners_clicks_are_carried_as_far_as_they_reach(make):
    cells = Cells.of(grid_of(STRAIGHT, 12.0))
    mapping, random = make(cells, SIZE, click_noise_px=0.5), np.random.default_rng(3)
    off_centre = np.array([9.0, 5.0])
    points = STRAIGHT.ground_from_image(cells.image.mean(axis=1) + off_centre)
    seen, errors = mapping.image_from_ground(points), []
    for _ in range(50):
        clicked = Cells(cells.ground, cells.image + random.normal(0, 0.5, cells.image.shape))
        errors.append(make(clicked, SIZE).ground_from_image(seen) - points)
    found = np.einsum('sni,snj->nij', errors, errors) / len(errors)
    predicted = mapping.calibration_covariance(points)
    share = np.trace(found, axis1=1, axis2=2) / np.trace(predicted, axis1=1, axis2=2)
    assert 0.85 < np.median(share) < 1.15
    assert share.max() < 1.5
