"""Fields of view as polygons, against images sampled on the ground."""

import json
import tarfile
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from lens_cameras import SIZE, camera
from mctrack_ros.ground import Camera, CameraMapping, ProjectiveMapping
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, polygon_from, seen_ground

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


def rolled(mapping, angle):
    """Turn a camera about its axis."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    lens, pose = mapping.camera, turn @ mapping.camera.rotation
    shift = turn @ mapping.camera.translation
    return CameraMapping(Camera(lens.intrinsics, lens.distortion, pose, shift), SIZE)


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(2.0, 25.0)),
    st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
    st.floats(400, 1500),
    st.sampled_from([0.0, -0.2, 0.1]),
    st.one_of(st.just(0.0), st.floats(-np.pi, np.pi)),
    st.integers(0, 2**31),
)
def test_region_holds_what_the_image_shows(eye, target, focal, k1, roll, seed):
    if np.hypot(eye[0] - target[0], eye[1] - target[1]) < 1.0:
        target = (target[0] + 2.0, target[1])
    focal = max(focal, 600) if k1 < 0 else focal
    mapping = rolled(camera(eye, (*target, 0.0), focal, (k1, 0, 0, 0, 0)), roll)
    places = np.random.default_rng(seed).uniform(-REACH, REACH, (3000, 2)) + eye[:2]
    agrees(mapping, seen_ground(mapping, REACH), places)


@pytest.mark.real_data
def test_annotated_people_stand_in_the_fields_of_the_cameras_that_show_them(data_root):
    folder = data_root / 'wildtrack'
    names = [f'CVLab{n}' for n in range(1, 5)] + [f'IDIAP{n}' for n in range(1, 4)]
    position, box = annotated(folder / 'annotations_positions_train.tar.gz')
    for index, name in enumerate(names):
        region = seen_ground(wildtrack_camera(folder / 'calibrations', name), 100.0)
        left, _, right, bottom = box[:, index].T
        foot = (left + right) / 2
        shown = (box[:, index] != -1).any(axis=1) & (bottom < 1079) & (foot > 0) & (foot < 1920)
        clear = shapely.distance(region.boundary, shapely.points(position)) > 0.3
        assert clear.sum() > 7000
        assert (shapely.contains_xy(region, *position.T) == shown)[clear].all(), name


def annotated(path):
    """Return the (n, 2) positions, m, and (n, 7, 4) boxes, px (-1: not shown), of people."""
    with tarfile.open(path) as archive:
        files = [archive.extractfile(each) for each in archive if each.name.endswith('.json')]
        people = [person for file in files for person in json.load(file)]
    number = np.array([person['positionID'] for person in people])
    boxes = [
        [[view[side] for side in ('xmin', 'ymin', 'xmax', 'ymax')] for view in views]
        for views in (sorted(p['views'], key=lambda view: view['viewNum']) for p in people)
    ]
    return np.column_stack([number % 480, number // 480]) * 0.025 - [3.0, 9.0], np.array(boxes)


def wildtrack_camera(folder, name):
    """Read a camera of the undistorted images; its file is in centimetres."""

    def numbers(file, tag):
        root = ElementTree.parse(folder / file).getroot()
        return np.array(root.find(tag).text.split(), float)

    matrix = numbers(f'intrinsic_zero/intr_{name}.xml', 'camera_matrix/data').reshape(3, 3)
    turn, shift = (numbers(f'extrinsic/extr_{name}.xml', tag) for tag in ('rvec', 'tvec'))
    intrinsics = matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    rotation = cv2.Rodrigues(turn)[0]
    return CameraMapping(Camera(intrinsics, np.zeros(5), rotation, shift / 100), (1920, 1080))


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


@pytest.mark.parametrize('tangential', [0.0, 0.005])
def test_camera_whose_lens_ends_inside_the_image_sees_up_to_there(tangential):
    lens = (-0.35, 0, tangential, -tangential, 0)
    mapping = camera((0, 0, 10), (0, 8, 0), 373.0, lens)
    region = seen_ground(mapping, REACH)
    places = np.random.default_rng(1).uniform(-REACH, REACH, (20000, 2))
    seen = sampled(mapping, places)
    inside = shapely.contains_xy(region, *places.T)
    assert region.is_valid
    assert not (inside & ~seen).any()
    assert (seen & ~inside).sum() < 0.1 * seen.sum()


@pytest.mark.parametrize('least_px', [13.0, 20.0])
def test_people_too_small_to_be_found_are_out_of_sight(least_px):
    mapping = camera((0, 0, 6), (0, 30, 0), 700.0, (0, 0, 0, 0, 0))
    region = seen_ground(mapping, 500.0, 1.75, least_px)
    edge = shapely.get_coordinates(region.exterior)
    far = edge[edge[:, 1] > edge[:, 1].max() / 2]
    np.testing.assert_allclose(mapping.height_px(far, 1.75), least_px, atol=0.01)
    assert seen_ground(mapping, 500.0, 1.75, 1e6).area < 1.0


def test_corners_may_go_either_way_and_end_where_they_began():
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    for corners in (square, square[::-1], [*square, square[0]]):
        assert polygon_from(corners).area == 4.0
    assert polygon_from([[0, 0], [4, 0], [1, 1], [0, 4]]).area == 4.0


@pytest.mark.parametrize(
    ('corners', 'reason'),
    [
        ([[0, 0], [2, 2], [2, 0], [0, 2]], r'cam1 crosses .* near \(1.00, 1.00\) m'),
        ([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2], [1, 1]], 'cam1 crosses or touches itself'),
        ([[0, 0], [4, 0], [2, 0], [2, 4]], 'cam1 crosses or touches itself'),
        ([[0, 0], [2, 0], [2, 0], [0, 2]], 'cam1 has a corner twice'),
        ([[0, 0], [9, 0], [18, 1e-6]], 'cam1 has no area'),
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
