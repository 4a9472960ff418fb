"""People walk below cameras that look down steeply."""

import cv2
import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.geometry.overhead_view import TALL_M
from mctrack_ros.perception.geometry.person_size import SizeTable
from sensor_noise import with_noise

SIZE = (320, 240)
PERIOD_NS = 40_000_000
EMPTY_IMAGES, SETTLING_IMAGES, WALK = 30, 10, 100


def projection(degrees, height_m=5.0, focal_px=200.0):
    """Return the (3, 4) projection of a camera so high that looks so far below the horizon."""
    down = np.radians(degrees)
    forward = np.array([0.0, np.cos(down), -np.sin(down)])
    right = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[focal_px, 0, SIZE[0] / 2], [0, focal_px, SIZE[1] / 2], [0, 0, 1]])
    return intrinsics @ np.column_stack([rotation, -rotation @ [0.0, 0.0, height_m]])


def image(matrix, places, rng):
    """Draw upright cylinders as thick as people."""
    image = np.full((SIZE[1], SIZE[0], 3), (60, 120, 60), np.uint8)
    around, up = np.meshgrid(np.linspace(0, 2 * np.pi, 16), [0.0, 1.75])
    for x, y in places:
        rim = [x + 0.25 * np.cos(around), y + 0.2 * np.sin(around), up, np.ones_like(up)]
        shown = matrix @ np.reshape(rim, (4, -1))
        hull = cv2.convexHull(np.rint((shown[:2] / shown[2]).T).astype(np.int32))
        cv2.fillConvexPoly(image, hull, (30, 30, 200))
    return with_noise(image, 2, rng)


def track(matrix, paths, seed):
    """Return what is detected of those who walk along paths, (images, 2) each, m."""
    pipeline = EventTracker(EventTrackerConfig(), ProjectiveMapping(matrix, SIZE))
    rng, reported = np.random.default_rng(seed), []
    for index in range(-EMPTY_IMAGES, len(paths[0])):
        drawn = image(matrix, [path[index] for path in paths] if index >= 0 else [], rng)
        stamp_ns = (index + EMPTY_IMAGES + 1) * PERIOD_NS
        reported.append(pipeline.step(drawn, stamp_ns, None).detections)
    return reported[EMPTY_IMAGES + SETTLING_IMAGES :]


def assert_followed(reported, paths, off_m):
    """Check that everybody has one detection and one id, and is no farther off than that."""
    ids = set()
    for index, rows in enumerate(reported):
        assert len(rows) == len(paths)
        for path in paths:
            off = np.linalg.norm(rows.position[:, :2] - path[SETTLING_IMAGES + index], axis=1)
            assert off.min() < off_m
        ids |= set(rows.local_id.tolist())
    assert len(ids) == len(paths)


@pytest.mark.parametrize('degrees', [30, 45, 60])
def test_one_person_is_one_however_steep_the_camera_looks(degrees):
    since, middle = np.arange(WALK), 5.0 / np.tan(np.radians(degrees))
    path = np.column_stack([-1.5 + 3.0 * since / WALK, middle + 0.5 * np.sin(since / 15)])
    assert_followed(track(projection(degrees), [path], degrees), [path], 0.4)


@pytest.mark.parametrize(
    ('degrees', 'height_m', 'focal_px'), [(75, 5.0, 200.0), (90, 5.0, 200.0), (90, 3.5, 130.0)]
)
def test_from_the_ceiling_people_stand_below_their_heads(degrees, height_m, focal_px):
    along, middle = np.linspace(-1.8, 1.8, 2 * WALK), height_m / np.tan(np.radians(degrees))
    paths = [
        np.column_stack([along, np.full(2 * WALK, middle + 0.8)]),
        np.column_stack([-along, np.full(2 * WALK, middle - 0.8)]),
    ]
    assert_followed(track(projection(degrees, height_m, focal_px), paths, degrees), paths, 0.25)


def test_a_box_seen_from_above_stands_where_it_was_put():
    mapping = ProjectiveMapping(projection(90.0, 3.5, 130.0), SIZE)
    sizes, place = (
        SizeTable(mapping),
        np.array([[0.1, 0.1], [1.0, -0.8], [-1.2, 0.9], [0.0, -1.0]]),
    )
    foot, person = mapping.image_from_ground(place), np.array([[0.5, TALL_M]])
    box = sizes.box_of(foot, person)
    np.testing.assert_allclose(sizes.foot_of(box), foot, atol=2.5)  # cells of the table: 4 px
    heads = mapping.image_from_ground(place, TALL_M)
    for inside in (foot, heads):
        assert (inside >= box[:, :2] - 4).all()
        assert (inside <= box[:, :2] + box[:, 2:] + 4).all()


def test_a_body_straight_below_is_as_large_as_it_is_thick():
    sizes = SizeTable(ProjectiveMapping(projection(90.0), SIZE))
    assert np.isfinite(sizes.table).all()
    across, upright, _, below = sizes.table[SIZE[1] // 8, SIZE[0] // 8]
    assert upright * TALL_M == pytest.approx(across * 0.5, rel=0.1)
    assert below == pytest.approx(0.5, abs=0.05)


def test_as_long_as_a_camera_looks_far_only_upright_metres_count():
    mapping = ProjectiveMapping(projection(20.0), SIZE)
    low = np.array([[0.0, 10.0], [4.0, 15.0], [-3.0, 20.0]])
    sizes = SizeTable(mapping).per_metre(np.rint(mapping.image_from_ground(low) / 4) * 4)
    seen = mapping.ground_from_image(np.rint(mapping.image_from_ground(low) / 4) * 4)
    np.testing.assert_allclose(sizes[:, 1], mapping.height_px(seen, 1.0), rtol=1e-12)
