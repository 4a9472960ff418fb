import numpy as np
import pytest

from mctrack_ros.perception import ImageState, ImageWatch

SHAPE = (96, 128, 3)
SECOND = 1_000_000_000


def scene(rng):
    return np.clip(rng.normal(120, 3, SHAPE), 0, 255).astype(np.uint8)


@pytest.mark.parametrize('level', [0, 3, 252, 255])
def test_black_and_white_are_blank(level):
    image = np.full(SHAPE, level, np.uint8)
    assert ImageWatch().look(image, 1) is ImageState.BLANK


def test_a_dark_image_that_shows_something_is_usable():
    image = np.random.default_rng(0).integers(5, 25, SHAPE).astype(np.uint8)
    assert ImageWatch().look(image, 1) is ImageState.USABLE


def test_noise_is_told_from_a_scene():
    rng = np.random.default_rng(0)
    watch = ImageWatch()
    assert watch.look(rng.integers(0, 256, SHAPE).astype(np.uint8), 1) is ImageState.NOISE
    assert watch.look(scene(rng), 2) is ImageState.USABLE


def test_frozen_is_the_same_to_the_last_pixel_for_a_second():
    rng = np.random.default_rng(0)
    watch, image = ImageWatch(), scene(rng)
    states = [watch.look(image, index * SECOND // 10) for index in range(12)]
    assert states == [ImageState.USABLE] * 10 + [ImageState.FROZEN] * 2
    assert watch.look(scene(rng), 2 * SECOND) is ImageState.USABLE
