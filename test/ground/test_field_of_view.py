"""Fields of view as polygons, against pictures sampled on the ground."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from lens_cameras import camera

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.ground.field_of_view import FieldOfViewError, polygon_from, seen_ground

REACH = 60.0


def sampled(mapping, places, reach=REACH):
    """Tell by projection alone which places a camera sees within its reach."""
    pixel = mapping.image_from_ground(places)
    inside = ((pixel >= 0) & (pixel <= mapping.image_size)).all(axis=1)
    return inside & (np.hypot(*(places - mapping.camera_position[:2]).T) <= reach)


def agrees(mapping, region, places, reach=REACH):
    """Compare a region with the oracle, but for places next to its edge."""
    clear = shapely.distance(region.boundary, shapely.points(places)) > 0.1
    contained = shapely.contains_xy(region, *places.T)
    assert clear.sum() > len(places) / 2
    assert (contained == sampled(mapping, places, reach))[clear].all()


@settings(max_examples=40, deadline=None)
@given(
    st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(2.0, 25.0)),
    st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
    st.floats(400, 1500),
    st.sampled_from([0.0, -0.2, 0.1]),
    st.integers(0, 2**31),
)
def test_region_holds_what_the_picture_shows(eye, target, focal, k1, seed):
    if np.hypot(eye[0] - target[0], eye[1] - target[1]) < 1.0:
        target = (target[0] + 2.0, target[1])
    mapping = camera(eye, (*target, 0.0), max(focal, 600 if k1 < 0 else 0), (k1, 0, 0, 0, 0))
    places = np.random.default_rng(seed).uniform(-REACH, REACH, (3000, 2)) + eye[:2]
    agrees(mapping, seen_ground(mapping, REACH), places)


def test_camera_straight_down_sees_a_rectangle():
    matrix = [[100, 0, -100, 500], [0, -100, -100, 500], [0, 0, -1, 5]]
    region = seen_ground(ProjectiveMapping(matrix, (200, 200)), REACH)
    assert region.normalize().equals_exact(shapely.box(-5, -5, 5, 5).normalize(), 1e-6)


def test_camera_over_its_whole_reach_sees_a_disc():
    mapping = camera((0, 0, 20), (0, 0.01, 0), 300.0, (0, 0, 0, 0, 0))
    assert seen_ground(mapping, 5.0).area == pytest.approx(np.pi * 25, rel=1e-3)


def test_reach_cuts_all_four_sides_into_one_region():
    mapping = camera((0, 0, 20), (0, 0.01, 0), 720.0, (0, 0, 0, 0, 0))
    region = seen_ground(mapping, 9.0)
    places = np.random.default_rng(1).uniform(-12, 12, (4000, 2))
    agrees(mapping, region, places, 9.0)
    assert region.geom_type == 'Polygon'


def test_camera_that_looks_at_the_sky_sees_nothing():
    mapping = camera((0, 0, 5), (0, 10, 20))
    assert seen_ground(mapping, REACH).is_empty


def test_camera_whose_lens_ends_inside_the_picture_sees_up_to_there():
    mapping = camera((0, 0, 10), (0, 5, 0), 330.0, (-0.25, 0, 0, 0, 0))
    region = seen_ground(mapping, REACH)
    assert region.is_valid
    assert shapely.contains_xy(region, *mapping.ground_from_image([[360, 288]])[0])


def test_people_too_small_to_be_found_are_out_of_sight():
    mapping = camera((0, 0, 6), (0, 30, 0), 700.0, (0, 0, 0, 0, 0))
    region = seen_ground(mapping, 500.0, 1.75, 20.0)
    edge = shapely.get_coordinates(region.exterior)
    farthest = edge[np.argmax(edge[:, 1])][None]
    assert mapping.height_px(farthest, 1.75) == pytest.approx(20.0, abs=0.1)
    assert seen_ground(mapping, 500.0, 1.75, 1e6).area < 1.0


def test_corners_may_go_either_way_and_end_where_they_began():
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    for corners in (square, square[::-1], [*square, square[0]]):
        assert polygon_from(corners).area == 4.0


@pytest.mark.parametrize(
    ('corners', 'reason'),
    [
        ([[0, 0], [2, 2], [2, 0], [0, 2]], r'cam1 crosses .* near \(1.00, 1.00\) m'),
        ([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2], [1, 1]], 'cam1 crosses or touches itself'),
        ([[0, 0], [1, 1], [0, 0]], 'cam1 has 2 different corners'),
        ([[0, 0], [1, 1], [2, 2], [5, 5]], 'cam1 has no area'),
        ([[0, 0], [1, 0], [np.nan, 2]], 'cam1 has a corner that is not finite'),
        ([[0, 0], [1, 0], [np.inf, 2]], 'cam1 has a corner that is not finite'),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], r'cam1 has corners of shape \(3, 3\)'),
        (np.empty((0, 2)), 'cam1 has 0 different corners'),
    ],
)
def test_bad_polygon_is_refused_in_one_line(corners, reason):
    with pytest.raises(FieldOfViewError, match=reason) as refusal:
        polygon_from(corners, 'cam1')
    assert '\n' not in str(refusal.value)
