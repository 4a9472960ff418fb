import cv2
import numpy as np
import pytest

from mctrack_ros.perception.background.view_change import scene_after

SHAPE = (144, 192, 3)
PERSON = np.s_[50:110, 90:112]


def ground(seed=0):
    rng = np.random.default_rng(seed)
    coarse = rng.integers(70, 140, (24, 32, 1)).astype(np.uint8)
    blocks = cv2.resize(coarse, SHAPE[1::-1], interpolation=cv2.INTER_NEAREST)
    return np.repeat(blocks[..., None], 3, axis=2)


def changed(image, model):
    return np.where(np.abs(image.astype(int) - model).max(axis=2) > 12, 255, 0).astype(np.uint8)


def with_person(image):
    image = image.copy()
    image[PERSON] = (30, 40, 200)
    return image


def after(image, model, people=None):
    people = np.zeros(SHAPE[:2], np.uint8) if people is None else people
    return scene_after(image, model, changed(image, model), people)


def people():
    mask = np.zeros(SHAPE[:2], np.uint8)
    mask[PERSON] = 255
    return mask


def lit():
    """Return the ground with a lamp over its left half."""
    image = ground().astype(float)
    image[:, :96] *= 1.6
    return np.clip(image, 0, 255).astype(np.uint8)


def test_a_lamp_is_taken_over_and_who_stands_in_it_is_not():
    image = lit()
    image[PERSON] = (30, 40, 200)
    found = after(image, ground(), people())
    assert np.abs(found.astype(int) - lit())[:, :85].max() <= 1
    assert found[PERSON][..., 0].min() > 50


@pytest.mark.parametrize('shift', [(5, 0), (-4, 3)])
def test_a_turned_camera_is_followed_and_people_are_no_background(shift):
    moved = np.roll(ground(), shift[::-1], axis=(0, 1))
    found = after(with_person(moved), ground(), people())
    inner = np.s_[55:105, 95:107]
    assert np.median(np.abs(found[inner].astype(int) - moved[inner])) <= 2


def test_people_and_another_scene_are_not_the_scene():
    crowd = ground()
    rng = np.random.default_rng(2)
    for left in range(10, 180, 30):
        crowd[30:120, left : left + 18] = rng.integers(0, 255, 3)
    assert after(crowd, ground()) is None
    assert after(ground(5), ground()) is None


def test_little_that_changes_tells_nothing():
    assert after(with_person(ground()), ground(), people()) is None
