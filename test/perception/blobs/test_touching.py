from dataclasses import replace

import numpy as np
import pytest

from mctrack_ros.perception.blobs.connected_components import Strength
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.blobs.touching import contacts
from mctrack_ros.tracking.appearance import NO_BALANCE


@pytest.fixture
def scene():
    """Two bright persons of 6 x 20 px, two columns apart, with a dim rim between them."""
    difference = np.zeros((60, 80), np.uint8)
    difference[20:40, 18:36] = 20
    difference[20:40, 20:26] = difference[20:40, 28:34] = 120
    return difference


BOXES = np.array([[20.0, 20, 6, 20], [28, 20, 6, 20]])
STRENGTH = Strength(0.4, 0.15)
BLOB = np.array([[18.0, 20, 18, 20]])


def image_of(difference, scale=1.0):
    image = np.repeat(difference[..., None], 3, axis=2)
    mask = 255 * (difference > 0).astype(np.uint8)
    return Frame(image, mask, mask, mask, np.zeros_like(image), difference, scale, NO_BALANCE)


def parts(difference, strength=STRENGTH, scale=1.0, box=BOXES):
    return contacts(box * scale, BLOB * scale, image_of(difference, scale), strength)


def test_a_dim_rim_joins_nobody(scene):
    one, other = parts(scene)
    assert one != other


def test_a_strong_bridge_joins(scene):
    scene[30, 25:29] = 120
    one, other = parts(scene)
    assert one == other


def test_an_arm_that_cleaning_has_cut_joins(scene):
    cleaned = image_of(scene).mask
    cleaned[:, 26:28] = 0
    scene[30, 25:29] = 120
    frame = replace(image_of(scene), mask=cleaned)
    blobs = np.array([[18.0, 20, 8, 20], [28, 20, 8, 20]])
    one, other = contacts(BOXES, blobs, frame, STRENGTH)
    assert one == other
    one, other = contacts(BOXES, blobs, replace(frame, found=cleaned), STRENGTH)
    assert one != other


def test_what_differs_in_colour_alone_joins_less_than_what_is_brighter_or_darker(scene):
    scene[30, 26:28] = 60
    one, other = parts(scene)
    assert one == other
    frame = image_of(scene)
    frame.image[30, 26:28, 1:] = 0
    one, other = contacts(BOXES, BLOB, frame, STRENGTH)
    assert one != other
    one, other = contacts(BOXES, BLOB, frame, STRENGTH._replace(colour=1.0))
    assert one == other


def test_the_scale_does_not_matter(scene):
    assert np.array_equal(parts(scene), parts(scene, scale=2.0))


def test_without_a_share_the_blob_is_one_part(scene):
    one, other = parts(scene, Strength(0.0, 0.0))
    assert one == other


def test_who_is_not_seen_is_in_no_part(scene):
    box = np.array([[20.0, 20, 6, 20], [60, 20, 6, 20], [np.nan] * 4])
    first, beside, nowhere = parts(scene, box=box)
    assert first >= 0
    assert beside == nowhere == -1


def test_a_box_beside_the_image_is_in_no_part(scene):
    assert parts(scene, box=np.array([[-30.0, 20, 6, 20]])).tolist() == [-1]


def test_somebody_expected_between_two_blobs_is_in_the_one_that_fills_more_of_the_box(scene):
    blobs = np.array([[18.0, 20, 9, 20], [27, 20, 9, 20]])
    box = np.array([[23.0, 20, 8, 20], [28, 20, 6, 20], [18, 20, 4, 20]])
    middle, right, left = contacts(box, blobs, image_of(scene), STRENGTH)
    assert left != right
    assert middle in (left, right)
