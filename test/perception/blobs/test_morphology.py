import cv2
import numpy as np
import pytest

from mctrack_ros.perception.blobs.morphology import opened

NO_LEGS = 255.0
SHAPES = [(40, 50), (37, 64), (1, 9), (7, 3), (120, 317)]


def masks(shape, rng):
    """Return sparse, dense and blotchy masks, an empty one and a full one."""
    blotchy = cv2.blur(rng.random(shape), (5, 3)) < 0.5
    chosen = [rng.random(shape) < share for share in (0.02, 0.7, 0.95)]
    empty = np.zeros(shape, bool)
    return [255 * mask.astype(np.uint8) for mask in (*chosen, blotchy, empty, ~empty)]


def by_opencv(mask, size):
    return cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((size, size), np.uint8))


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('size', [1, 3, 5])
def test_opening_is_that_of_opencv(shape, size):
    rng = np.random.default_rng(0)
    for mask in masks(shape, rng):
        difference = rng.integers(0, 256, shape, np.uint8)
        assert np.array_equal(opened(mask, difference, size, NO_LEGS), by_opencv(mask, size))


@pytest.mark.parametrize('shape', SHAPES)
def test_what_clearly_hangs_below_stays(shape):
    rng = np.random.default_rng(0)
    for mask in masks(shape, rng):
        difference = rng.integers(0, 256, shape, np.uint8)
        clear = (mask > 0) & (difference > 100)
        expected = by_opencv(mask, 3) > 0
        for row in range(1, shape[0]):
            above = np.pad(expected[row - 1], 1)
            expected[row] |= clear[row] & (above[:-2] | above[1:-1] | above[2:])
        found = opened(mask, difference, 3, 100.0)
        assert np.array_equal(found, 255 * expected.astype(np.uint8))


def test_legs_stay_and_arms_and_specks_go():
    mask, difference = np.zeros((20, 20), np.uint8), np.full((20, 20), 60, np.uint8)
    mask[3:10, 8:12] = 255
    body = mask.copy()
    mask[10:17, 9] = body[10:17, 9] = 255  # a leg
    mask[3, 12:18] = mask[15, 2] = 255
    assert np.array_equal(opened(mask, difference, 3, 20.0), body)


def test_a_rim_of_compression_is_no_leg():
    mask, difference = np.zeros((20, 20), np.uint8), np.full((20, 20), 60, np.uint8)
    mask[3:10, 8:12] = 255
    body = mask.copy()
    mask[10:12, 9] = 255
    difference[10:12, 9] = 15
    assert np.array_equal(opened(mask, difference, 3, 20.0), body)
