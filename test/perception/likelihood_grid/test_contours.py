"""Outlines of cylinders in images."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lens_cameras import camera
from mctrack_ros.perception.likelihood_grid.contours import POINTS, SHAPES, outlines

HEIGHT, RADIUS = 1.75, 0.25


def surface(mapping, place, shape='cylinder'):
    """Return pixels all over a solid."""
    angle, level = np.meshgrid(np.linspace(0, 2 * np.pi, 180), np.linspace(0, HEIGHT, 60))
    radius = RADIUS * np.interp(level.ravel() / HEIGHT, *SHAPES[shape])
    turn = np.column_stack([np.cos(angle.ravel()), np.sin(angle.ravel())])
    ring = place + radius[:, None] * turn
    return mapping.image_from_ground(ring, level.ravel())


@pytest.mark.parametrize('eye', [(-5.0, -4.0, 3.0), (-5.0, -4.0, 1.2), (4.0, 1.0, 6.0)])
@pytest.mark.parametrize('place', [(0.0, 0.0), (1.0, -0.7)])
def test_the_outline_goes_around_all_that_is_seen_of_a_cylinder(eye, place):
    mapping = camera(eye=eye, target=(0.0, 0.0, 0.5), focal=450.0)
    contour, _ = outlines(mapping, np.array([place]), HEIGHT, RADIUS, 'cylinder')
    inside = [
        cv2.pointPolygonTest(contour[0].astype(np.float32), tuple(map(float, pixel)), True)
        for pixel in surface(mapping, np.array(place))
    ]
    assert min(inside) > -2.0  # corners are cut between two points
    hull = cv2.convexHull(surface(mapping, np.array(place)).astype(np.float32))
    assert cv2.contourArea(contour[0].astype(np.float32)) == pytest.approx(
        cv2.contourArea(hull), rel=0.03
    )


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('eye', [(-5.0, -4.0, 1.2), (-4.0, -3.0, 3.0)])
def test_the_outline_of_every_shape_covers_what_is_seen_of_it_and_no_more(eye, shape):
    mapping = camera(eye=eye, target=(0.0, 0.0, 0.5), focal=450.0)
    place = np.array([0.3, 0.2])
    contour, _ = outlines(mapping, place[None], HEIGHT, RADIUS, shape)
    width, height = mapping.image_size
    drawn, seen = (np.zeros((height, width), np.uint8) for _ in range(2))
    cv2.fillPoly(drawn, [np.rint(contour[0]).astype(np.int32)], 255)
    column, row = np.rint(surface(mapping, place, shape)).astype(int).T
    seen[row, column] = 255
    seen = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, np.ones((9, 9), np.uint8))
    both, either = ((drawn & seen) > 0).sum(), ((drawn | seen) > 0).sum()
    assert both / either > 0.93


@settings(max_examples=30, deadline=None)
@given(st.floats(-2, 2), st.floats(-2, 2), st.sampled_from([-0.25, -0.1, 0.0, 0.1]))
def test_points_lie_evenly_and_normals_stand_on_the_outline(x, y, k1):
    mapping = camera((-5.0, -4.0, 3.0), (0.0, 0.0, 0.5), 450.0, (k1, 0, 0, 0, 0))
    contour, normal = outlines(mapping, np.array([[x, y]]), HEIGHT, RADIUS, 'cylinder')
    chord = np.roll(contour[0], -1, axis=0) - np.roll(contour[0], 1, axis=0)
    length = np.hypot(*chord.T)
    assert length.max() < 1.3 * np.median(length)
    across = np.column_stack([np.cos(normal[0]), np.sin(normal[0])])
    along = np.abs((across * chord).sum(axis=1)) / length
    assert np.median(along) < 0.05
    assert ((normal >= 0) & (normal <= np.pi)).all()


def test_sides_are_upright_and_as_far_apart_as_the_cylinder_is_wide(mapping):
    contour, normal = outlines(mapping, np.zeros((1, 2)), HEIGHT, RADIUS, 'cylinder')
    middle = mapping.image_from_ground(np.zeros((1, 2)), HEIGHT / 2)[0]
    beside = np.abs(contour[0, :, 1] - middle[1]) < 15
    left, right = (
        contour[0, beside & (sign * (contour[0, :, 0] - middle[0]) > 0), 0].mean()
        for sign in (-1, 1)
    )
    distance = np.linalg.norm(mapping.camera_position - [0, 0, HEIGHT / 2])
    assert right - left == pytest.approx(2 * RADIUS * 450.0 / distance, rel=0.05)
    turned = np.minimum(normal[0, beside], np.pi - normal[0, beside])
    assert turned.max() < 0.2


def test_who_stands_behind_or_around_the_camera_has_no_outline(mapping):
    places = np.array([[-12.0, -10.0], [-5.0, -4.1], [0.0, 0.0]])
    contour, normal = outlines(mapping, places, HEIGHT, RADIUS, 'cylinder')
    assert contour.shape == (3, POINTS, 2)
    assert np.isfinite(contour).all(axis=(1, 2)).tolist() == [False, False, True]
    assert np.isfinite(normal).all(axis=1).tolist() == [False, False, True]
