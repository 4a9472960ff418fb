"""Somebody walks before a camera 5 m above the ground that looks down steeply."""

import cv2
import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception import CameraConfig, CameraPipeline
from mctrack_ros.perception.sizes import SizeTable

SIZE, FOCAL_PX, EYE = (320, 240), 200.0, np.array([0.0, 0.0, 5.0])
PERIOD_NS = 40_000_000
EMPTY_PICTURES, WALK = 30, 100


def projection(degrees):
    """Return the (3, 4) projection of the camera that looks so far below the horizon."""
    down = np.radians(degrees)
    forward = np.array([0.0, np.cos(down), -np.sin(down)])
    right = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[FOCAL_PX, 0, SIZE[0] / 2], [0, FOCAL_PX, SIZE[1] / 2], [0, 0, 1]])
    return intrinsics @ np.column_stack([rotation, -rotation @ EYE])


def picture(matrix, places, rng):
    """Draw upright cylinders as thick as people."""
    image = np.full((SIZE[1], SIZE[0], 3), (60, 120, 60), np.uint8)
    around, up = np.meshgrid(np.linspace(0, 2 * np.pi, 16), [0.0, 1.75])
    for x, y in places:
        rim = [x + 0.25 * np.cos(around), y + 0.2 * np.sin(around), up, np.ones_like(up)]
        shown = matrix @ np.reshape(rim, (4, -1))
        hull = cv2.convexHull(np.rint((shown[:2] / shown[2]).T).astype(np.int32))
        cv2.fillConvexPoly(image, hull, (30, 30, 200))
    return np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize('degrees', [30, 45, 60])
def test_one_person_is_one_however_steep_the_camera_looks(degrees):
    matrix, rng = projection(degrees), np.random.default_rng(degrees)
    pipeline = CameraPipeline(CameraConfig(), ProjectiveMapping(matrix, SIZE))
    middle, told = 5.0 / np.tan(np.radians(degrees)), []
    for index in range(EMPTY_PICTURES + WALK):
        since = index - EMPTY_PICTURES
        place = np.array([-1.5 + 3.0 * since / WALK, middle + 0.5 * np.sin(since / 15)])
        image = picture(matrix, [place] if since >= 0 else [], rng)
        result = pipeline.step(image, (index + 1) * PERIOD_NS, None)
        if since >= 10:
            told.append(result.detections)
            assert len(told[-1]) == 1
            assert np.linalg.norm(told[-1].position[0, :2] - place) < 0.4
    assert len(np.unique(np.concatenate([rows.local_id for rows in told]))) == 1


def test_a_body_straight_below_is_as_large_as_it_is_thick():
    sizes = SizeTable(ProjectiveMapping(projection(90.0), SIZE))
    across, upright, _ = sizes.table.reshape(-1, 3).T
    assert np.isfinite(sizes.table).all()
    assert (upright > 0.25 * across).all()


def test_as_long_as_a_camera_looks_far_only_upright_metres_count():
    mapping = ProjectiveMapping(projection(20.0), SIZE)
    low = np.array([[0.0, 10.0], [4.0, 15.0], [-3.0, 20.0]])
    sizes = SizeTable(mapping).per_metre(np.rint(mapping.image_from_ground(low) / 4) * 4)
    seen = mapping.ground_from_image(np.rint(mapping.image_from_ground(low) / 4) * 4)
    np.testing.assert_allclose(sizes[:, 1], mapping.height_px(seen, 1.0), rtol=1e-12)
