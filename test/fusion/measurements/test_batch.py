"""The images of a tick as measurements."""

import numpy as np
import pytest

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.config import ConstantVelocityConfig
from mctrack_ros.interfaces import LARGEST_DISTANCE, LARGEST_VARIANCE, TEMPLATE_SIZE, Detections

CONFIG = JointConfig(motion=ConstantVelocityConfig(sensor_sigma=0.3, acceleration_density=6.0))
NOW_NS = 90_000_000_000


def looks_of(*images):
    """Return images of cameras 2, 0, 1, one after the other."""
    return Batch(images, [2, 0, 1][: len(images)], NOW_NS, CONFIG)


def rows(count, before_ns=0, **columns):
    place, covariance = np.zeros((count, 3)), np.tile(np.eye(2), (count, 1, 1))
    return Detections.build(
        NOW_NS - before_ns, **({'position': place, 'covariance': covariance} | columns)
    )


def test_what_is_older_is_less_certain():
    """By the sensor's own error, and by where one may have gone in .1 s: 6 x .1³ / 3."""
    told = [[[0.5, 0.1], [0.3, 0.4]]]
    batch = looks_of(rows(1, covariance=told), rows(1, 100_000_000, covariance=told))
    np.testing.assert_allclose(batch.seconds, [0.0, -0.1])
    sure = np.array([[0.59, 0.2], [0.2, 0.49]])
    np.testing.assert_allclose(batch.noise, [sure, sure + 0.002 * np.eye(2)], rtol=1e-6)
    assert batch.camera.tolist() == [2, 0]
    assert batch.stamp_ns.tolist() == [NOW_NS, NOW_NS - 100_000_000]


@pytest.mark.parametrize('seed', range(10))
def test_boxes_overlap_that_meet_another_one_of_their_image(seed):
    """Against trying all; groups are overlapped, and overlap nobody."""
    rng = np.random.default_rng(seed)
    images = []
    for _ in range(3):
        box = np.column_stack([rng.integers(0, 60, (8, 2)), rng.integers(1, 20, (8, 2))])
        counts = rng.choice([1, 1, 1, 3], 8).astype(np.uint8)
        images.append(rows(8, box=box, member_count=counts))
    batch = looks_of(*images)
    expected = []
    for image in images:
        left, top, width, height = image.box.T
        single = image.member_count == 1
        for one in range(8):
            meets = (left < left[one] + width[one]) & (left[one] < left + width)
            meets &= (top < top[one] + height[one]) & (top[one] < top + height)
            meets[one] = False
            expected.append(not single[one] or (meets & single).any())
    assert batch.is_overlapped.tolist() == expected
    assert batch.single.tolist() == np.flatnonzero(batch.detections.member_count == 1).tolist()
    assert sorted([*batch.single, *batch.groups]) == list(range(24))


def test_what_cannot_be_a_place_is_left_out():
    """One that can, and then one thing about each that cannot."""
    bad_places = [
        [np.nan, 0, 0],
        [0, np.inf, 0],
        [LARGEST_DISTANCE, 0, 0],
        [0, -LARGEST_DISTANCE, 0],
    ]
    most = LARGEST_VARIANCE
    bad_spreads = [
        [[-1, 0], [0, 1]], [[1, 0], [0, 0]], [[1, 1], [1, 1]], [[1, 0.9], [1.3, 1]],
        [[most, 0], [0, 1]], [[1, 0], [0, most]], [[np.nan, 0], [0, 1]],
    ]  # fmt: skip
    count = 1 + len(bad_places) + len(bad_spreads)
    place, covariance = np.zeros((count, 3)), np.tile(np.eye(2), (count, 1, 1))
    place[1 : 1 + len(bad_places)] = bad_places
    covariance[1 + len(bad_places) :] = bad_spreads
    covariance[0] = [[1, 0.8], [1.1, 1]]
    batch = looks_of(rows(2), rows(count, position=place, covariance=covariance))
    assert batch.image.tolist() == [0, 0, 1]
    np.testing.assert_allclose(batch.noise[2], [[1.09, 0.95], [0.95, 1.09]], rtol=1e-6)


def test_columns_of_all_images_lie_one_after_the_other():
    template = np.zeros((2, TEMPLATE_SIZE), np.float32)
    template[1, 5] = 1.0
    batch = looks_of(
        rows(2, score=[0.1, 0.2], template=template, local_id=[3, 4]),
        rows(2, score=[0.3, 0.4], position=[[np.nan, 0, 0], [1, 2, 0]], class_id=[1, 3]),
    )
    np.testing.assert_allclose(batch.detections.score, [0.1, 0.2, 0.4], rtol=1e-6)
    assert batch.is_described.tolist() == [False, True, False]
    assert batch.has_templates
    assert not looks_of(rows(2)).has_templates
    assert batch.rows['local_id'].tolist() == [3, 4, 0]
    assert batch.rows['class_id'].tolist() == [0, 0, 3]
    np.testing.assert_array_equal(batch.position, [[0, 0], [0, 0], [1, 2]])
