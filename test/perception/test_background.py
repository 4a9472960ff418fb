import numpy as np
import pytest

from mctrack_ros.perception.background import (
    BackgroundConfig,
    MedianBackground,
    median_of_nine,
)

SECOND = 1_000_000_000


def flat(level, shape=(12, 16, 3)):
    return np.full(shape, level, np.uint8)


def learned(image, rate=25, seconds=2.0):
    background = MedianBackground(BackgroundConfig())
    for index in range(int(seconds * rate) + 2):
        background.apply(image, index * SECOND // rate)
    return background, (int(seconds * rate) + 2) * SECOND // rate


def test_median_of_nine_agrees_with_numpy():
    images = np.random.default_rng(0).integers(0, 256, (9, 20, 30, 3), np.uint8)
    assert np.array_equal(median_of_nine(list(images)), np.median(images, axis=0))


@pytest.mark.parametrize('level', [0, 255])
def test_model_saturates_at_the_ends_of_the_range(level):
    background, now = learned(flat(level))
    for index in range(200):
        background.apply(flat(level), now + index * SECOND // 5)
    assert (background.model == level).all()


@pytest.mark.parametrize('rate', [5, 25, 100])
def test_rate_of_learning_does_not_depend_on_the_frame_rate(rate):
    background, now = learned(flat(100), rate)
    for index in range(2 * rate):
        background.apply(flat(108), now + index * SECOND // rate)
    assert 108 - background.model.max() <= 1
    assert background.model.min() > 100


def test_foreground_burns_in_more_slowly():
    background, now = learned(flat(90))
    image = flat(90)
    image[4:8, 4:8] = 200
    for index in range(50):
        mask = background.apply(image, now + index * SECOND // 5)
    assert (mask[4:8, 4:8] == 255).all()
    assert background.model.max() <= 90 + 50 // 10 + 1


def test_threshold_follows_the_noise():
    rng = np.random.default_rng(1)

    def noisy(sigma):
        return np.clip(rng.normal(120, sigma, (96, 128, 3)), 0, 255).astype(np.uint8)

    quiet, loud = MedianBackground(BackgroundConfig()), MedianBackground(BackgroundConfig())
    for index in range(60):
        quiet.apply(noisy(1), index * SECOND // 25)
        loud_mask = loud.apply(noisy(8), index * SECOND // 25)
    assert quiet.threshold == BackgroundConfig().minimum_threshold
    assert loud.threshold > 25
    assert (loud_mask > 0).mean() < 0.01


def test_changed_picture_is_learned_anew():
    background, now = learned(flat(50))
    assert background.apply(flat(200), now + SECOND) is None
    for index in range(30):
        mask = background.apply(flat(200), now + 2 * SECOND + index * SECOND // 25)
    assert not mask.any()
