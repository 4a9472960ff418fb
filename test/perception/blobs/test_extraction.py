import cv2
import numpy as np
import pytest

from mctrack_ros.perception.blobs.extraction import BlobConfig, clean_mask, find_blobs
from mctrack_ros.perception.geometry.person_size import SizeTable

SHAPE = (240, 320)


@pytest.fixture
def person(mapping):
    """Return the box, px, of somebody who stands at a place."""
    sizes = SizeTable(mapping)

    def box(x, y, width=0.6, height=1.75):
        foot = mapping.image_from_ground([[x, y]])
        return np.rint(sizes.box_of(foot, np.array([[width, height]]))[0]).astype(int)

    return box


@pytest.fixture
def blobs_of(mapping):
    """Find the blobs of filled boxes with their differences from the background."""

    def find(*boxes, config=None, differences=None):
        mask, difference = np.zeros((2, *SHAPE), np.uint8)
        for index, (left, top, width, height) in enumerate(boxes):
            part = np.s_[max(top, 0) : top + height, max(left, 0) : left + width]
            mask[part] = 255
            difference[part] = 100 if differences is None else differences[index]
        config = config or BlobConfig()
        return find_blobs(mask, difference, mapping, SizeTable(mapping), 1.0, config)

    return find


def test_person_is_one_blob_with_its_foot_on_the_ground(person, blobs_of):
    blobs = blobs_of(person(1.0, 2.0))
    assert len(blobs) == 1
    assert np.allclose(blobs.position[0], [1.0, 2.0], atol=0.2)
    assert blobs.area[0] == blobs.box[0, 2] * blobs.box[0, 3]
    assert not blobs.truncated[0]


def test_upper_and_lower_half_become_one_person(person, blobs_of):
    left, top, width, height = person(0.0, 0.0)
    half = height // 2 - 2
    blobs = blobs_of((left, top, width, half), (left, top + half + 4, width, height - half - 4))
    assert blobs.box.tolist() == [[left, top, width, height]]


def test_neighbours_are_not_joined(person, blobs_of):
    assert len(blobs_of(person(0.0, 0.0), person(1.1, 0.0))) == 2


def test_specks_are_dropped(person, blobs_of):
    left, top, _, _ = person(0.0, 0.0)
    assert len(blobs_of((left, top, 4, 4))) == 0


def test_who_is_too_far_away_is_left_out(person, blobs_of):
    near, far = person(0.0, 0.0), person(0.0, 14.0)
    config = BlobConfig(farthest_height_px=(near[3] + far[3]) / 2)
    assert blobs_of(near, far, config=config).box.tolist() == [near.tolist()]


def test_blob_at_the_edge_is_truncated(person, blobs_of):
    _, top, width, height = person(0.0, 0.0)
    assert blobs_of((0, top, width, height)).truncated.all()


def test_faint_rim_does_not_move_the_foot(person, blobs_of):
    left, top, width, height = person(0.0, 0.0)
    rim = (left - 2, top - 2, width + 4, height + 4)
    blobs = blobs_of(rim, (left, top, width, height), differences=[14, 100])
    assert blobs.box.tolist() == [[left, top, width, height]]


def test_blobs_come_from_left_to_right(person, blobs_of):
    boxes = [person(x, 0.0) for x in (3.0, -3.0, 0.0)]
    assert np.all(np.diff(blobs_of(*boxes).box[:, 0]) > 0)


def test_noise_is_removed_and_persons_stay(person):
    rng = np.random.default_rng(0)
    mask = np.where(rng.random(SHAPE) < 0.02, 255, 0).astype(np.uint8)
    left, top, width, height = person(0.0, 0.0)
    cv2.rectangle(mask, (left, top), (left + width - 1, top + height - 1), 255, -1)
    difference = np.where(mask > 0, rng.integers(12, 20, SHAPE), 0).astype(np.uint8)
    cleaned = clean_mask(mask, difference, 12.0, BlobConfig())
    assert (cleaned[top : top + height, left : left + width] == 255).all()
    assert (cleaned > 0).sum() < 1.2 * width * height


@pytest.mark.parametrize('name', ['opening_px', 'closing_px'])
def test_even_kernels_are_refused(name):
    with pytest.raises(ValueError, match=f'{name} is 4, expected an odd number'):
        BlobConfig(**{name: 4})
