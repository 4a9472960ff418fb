import numpy as np
import pytest

from mctrack_ros.perception.contacts import contacts
from mctrack_ros.perception.picture import Picture


@pytest.fixture
def scene():
    """Two bright persons of 6 x 20 px, two columns apart, with a dim rim between them."""
    difference = np.zeros((60, 80), np.uint8)
    difference[20:40, 18:36] = 20
    difference[20:40, 20:26] = difference[20:40, 28:34] = 120
    return difference


BOXES = np.array([[20.0, 20, 6, 20], [28, 20, 6, 20]])
BLOB = np.array([[18.0, 20, 18, 20]])


def parts(difference, share=0.5, scale=1.0):
    picture = Picture(
        np.zeros((60, 80, 3), np.uint8), 255 * (difference > 0).astype(np.uint8), difference, scale
    )
    return contacts(np.array([0, 0]), BOXES * scale, BLOB * scale, picture, share)


def test_a_dim_rim_joins_nobody(scene):
    one, other = parts(scene)
    assert one != other


def test_a_strong_bridge_joins(scene):
    scene[30, 25:29] = 120
    one, other = parts(scene)
    assert one == other


def test_the_scale_does_not_matter(scene):
    assert np.array_equal(parts(scene), parts(scene, scale=2.0))


def test_without_a_share_the_blob_is_one_part(scene):
    one, other = parts(scene, share=0.0)
    assert one == other


def test_who_is_alone_or_not_seen_keeps_to_himself(scene):
    picture = Picture(np.zeros((60, 80, 3), np.uint8), scene, scene, 1.0)
    place = contacts(np.array([0, -1, 1]), np.zeros((3, 4)), np.zeros((2, 4)), picture, 0.5)
    assert place.tolist() == [0, -1, 1]


def test_a_box_beside_the_picture_is_in_no_part(scene):
    picture = Picture(np.zeros((60, 80, 3), np.uint8), scene, scene, 1.0)
    box = np.array([[-30.0, 20, 6, 20], [20, 20, 6, 20]])
    one, other = contacts(np.array([0, 0]), box, BLOB, picture, 0.5)
    assert one != other
