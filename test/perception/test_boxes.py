"""Boxes of a detector on the ground, by every kind of calibration."""

from dataclasses import replace

import numpy as np
import pytest

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    FORMATS,
    METHODS,
    CameraMapping,
    ProjectiveMapping,
    grid_from_points,
    mapping_from_grid,
    read_calibration,
    write_calibration,
)
from mctrack_ros.ground.camera.pinhole import PARAMETERS
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception import boxes_to_detections, positions_to_detections
from mctrack_ros.perception.boxes import BodyModel

IMAGE_FROM_WORLD = np.array([[800.0, 0, 320], [0, 800.0, 240], [0, 0, 1]]) @ np.array(
    [[1.0, 0, 0, 0], [0, -0.5, -np.sqrt(0.75), 2.0], [0, np.sqrt(0.75), -0.5, 6.0]]
)


def upright_boxes(mapping, places, body):
    away = places - mapping.camera_position[:2]
    nearest = places - body.reach * away / np.linalg.norm(away, axis=1, keepdims=True)
    foot, toes = mapping.image_from_ground(places), mapping.image_from_ground(nearest)
    head = mapping.image_from_ground(places, body.height)
    middle = (foot[:, 0] + head[:, 0]) / 2
    return np.column_stack([middle - 20, head[:, 1], np.full(len(foot), 40), (toes - head)[:, 1]])


def test_a_box_is_put_where_its_person_stands():
    mapping = ProjectiveMapping(IMAGE_FROM_WORLD, (640, 480))
    places = np.array([[0.0, 0.5], [1.0, 2.0], [-1.5, 3.0]])
    boxes = upright_boxes(mapping, places, BodyModel())
    found = boxes_to_detections(boxes, np.ones(3), mapping, 5)
    np.testing.assert_allclose(found.position[:, :2], places, atol=0.01)
    assert (np.linalg.eigvalsh(found.covariance.astype(float)) > 0).all()


def test_hidden_feet_leave_the_place_to_the_head_and_less_certain():
    mapping = ProjectiveMapping(IMAGE_FROM_WORLD, (640, 480))
    place = np.array([[0.0, 2.0]])
    box = upright_boxes(mapping, place, BodyModel())
    whole = boxes_to_detections(box, np.ones(1), mapping, 5)
    low = ProjectiveMapping(IMAGE_FROM_WORLD, (640, int(box[0, 1] + box[0, 3])))
    cut = boxes_to_detections(box - [0, 0, 0, 1], np.ones(1), low, 5)
    assert cut.truncated[0]
    assert np.linalg.norm(cut.position[0, :2] - place[0]) < 0.1
    assert np.trace(cut.covariance[0]) > np.trace(whole.covariance[0])


def test_feet_behind_a_nearer_person_are_less_certain():
    mapping = ProjectiveMapping(IMAGE_FROM_WORLD, (640, 480))
    boxes = upright_boxes(mapping, np.array([[0.0, 2.0], [0.05, 1.5]]), BodyModel())
    alone = boxes_to_detections(boxes[:1], np.ones(1), mapping, 5)
    both = boxes_to_detections(boxes, np.ones(2), mapping, 5)
    nearer = boxes_to_detections(boxes[1:], np.ones(1), mapping, 5)
    assert np.trace(both.covariance[0]) > np.trace(alone.covariance[0])
    np.testing.assert_array_equal(both.covariance[1], nearer.covariance[0])


PLACES = np.array([[0.0, 5.0], [4.0, 12.0], [-6.0, 20.0], [8.0, 8.0]])
BENT, STRAIGHT = camera(), camera(distortion=(0, 0, 0, 0, 0))
POINTS = seen_grid(BENT, 4.0)
GRID = grid_from_points(
    'cam', [f'{x:g}/{y:g}' for x, y in POINTS], POINTS, BENT.image_from_ground(POINTS)
)[0]


def off_m(mapping, truth=BENT):
    """Return how far from their places people are put whom a true camera sees, m."""
    boxes = upright_boxes(truth, PLACES, BodyModel())
    found = boxes_to_detections(boxes, np.ones(len(PLACES)), mapping, 5)
    assert (np.linalg.eigvalsh(found.covariance.astype(float)) > 0).all()
    return np.linalg.norm(found.position[:, :2] - PLACES, axis=1).max()


@pytest.mark.parametrize('method', METHODS)
def test_people_stand_where_they_are_by_every_method_of_a_grid(method):
    # one homography for all cannot follow the lens, and equal ratios are the paper's approximation
    most = {'fitted': 0.05, 'cell': 0.3, 'iterated': 0.5, 'homography': 1.0}
    assert off_m(mapping_from_grid(GRID, SIZE, method)) < most[method]


@pytest.mark.parametrize('kind', FORMATS)
def test_people_stand_where_they_are_by_every_format_of_a_calibration(kind, tmp_path):
    truth = STRAIGHT if 'from' in kind else camera(distortion=(-0.05, 0, 0, 0, 0))
    write_calibration(truth, tmp_path / 'cam', kind, 'cam')
    assert off_m(read_calibration(tmp_path / 'cam', SIZE), truth) < 0.05


@pytest.mark.parametrize('height', [1.5, 1.7, 2.0, 3.0])
def test_a_camera_as_high_as_heads_puts_people_where_their_feet_are(height):
    low = camera(eye=(0.0, -10.0, height), target=(0.0, 30.0, 0.0))
    boxes = upright_boxes(low, PLACES, BodyModel())
    found = boxes_to_detections(boxes, np.ones(len(PLACES)), low, 5)
    np.testing.assert_allclose(found.position[:, :2], PLACES, atol=0.05)


def test_places_are_as_far_off_as_their_covariances_say():
    random = np.random.default_rng(3)
    places = np.tile(PLACES, (500, 1)) + random.uniform(-2, 2, (2000, 2))
    body = BodyModel()
    boxes = upright_boxes(BENT, places, body)
    noise = body.edge_sigma * boxes[:, 3:]
    left, bottom, top = (random.normal(0, noise) for _ in range(3))
    boxes += np.column_stack([left, top, np.zeros(len(boxes)), bottom - top])
    squared = []
    for box, place in zip(boxes, places):
        found = boxes_to_detections([box], [1.0], BENT, 5)
        gap = found.position[0, :2] - place
        squared.append(gap @ np.linalg.solve(found.covariance[0].astype(float), gap))
    assert 1.4 < np.mean(squared) < 2.6  # 2 degrees of freedom


def test_what_a_calibration_says_of_itself_is_in_the_covariance():
    position = np.diag([name in ('x', 'y', 'z') for name in PARAMETERS])  # unsure by a metre
    unsure = CameraMapping(replace(BENT.camera, covariance=position), SIZE)
    boxes = upright_boxes(BENT, PLACES, BodyModel())
    sure, other = (
        boxes_to_detections(boxes, np.ones(4), each, 5).covariance for each in (BENT, unsure)
    )
    added = unsure.calibration_covariance(PLACES)
    assert (np.trace(added, axis1=1, axis2=2) > 1.0).all()
    np.testing.assert_allclose(other - sure, added, rtol=0.05, atol=0.01)


def test_boxes_above_the_horizon_are_left_out_and_what_is_no_person_stands_on_its_lower_edge():
    box = np.append(upright_boxes(BENT, PLACES[:1], BodyModel())[0, :2], [40.0, 60.0])
    sky = [100.0, -900.0, 20.0, 40.0]
    found = boxes_to_detections(
        [box, sky], [0.5, 1.0], BENT, 5, class_id=[ClassCode.VEHICLE, ClassCode.PERSON]
    )
    assert found.class_id.tolist() == [ClassCode.VEHICLE]
    foot = BENT.image_from_ground(found.position[:, :2])[0]
    np.testing.assert_allclose(foot, box[:2] + np.array([20, 60]), atol=0.01)


def test_a_box_at_any_edge_of_the_image_is_truncated():
    width = SIZE[0]
    boxes = [[300, 200, 30, 80], [0, 300, 30, 80], [width - 30, 300, 30, 80], [300, 500, 30, 76]]
    found = boxes_to_detections(boxes, np.ones(4), BENT, 5)
    assert found.truncated.tolist() == [0, 1, 1, 1]


@pytest.mark.parametrize(
    ('boxes', 'score'), [([[1, 2, -3, 4]], [1]), ([[1, 2, np.nan, 4]], [1]), ([[1, 2, 3, 4]], [2])]
)
def test_what_is_no_box_or_score_is_refused(boxes, score):
    with pytest.raises(ValueError, match=r'a (box|score) is not'):
        boxes_to_detections(boxes, score, BENT, 5)


def test_no_boxes_make_no_detections():
    assert len(boxes_to_detections([], [], BENT, 5)) == 0


def test_positions_are_as_certain_as_told_or_as_a_lower_edge_there():
    rows = positions_to_detections(PLACES[:2], [0.5, 1.0], BENT, 7, sigma=[0.5, np.nan])
    np.testing.assert_allclose(rows.position[:, :2], PLACES[:2])
    np.testing.assert_allclose(rows.covariance[0], 0.25 * np.eye(2))
    along = np.sqrt(np.linalg.eigvalsh(rows.covariance[1].astype(float)))
    assert 0.02 < along[0] < along[1] < 0.5
    behind = positions_to_detections([[3.0, -300.0]], [1.0], BENT, 7)
    assert len(behind) == 0
