import cv2
import numpy as np
import pytest

from mctrack_ros.perception.background.light import gains
from mctrack_ros.perception.background.model import Background, BackgroundConfig, approach
from mctrack_ros.perception.background.objects import objects_in
from mctrack_ros.perception.background.plate import median_of_nine

SECOND = 1_000_000_000


def flat(level, shape=(12, 16, 3)):
    return np.full(shape, level, np.uint8)


def look(background, image, stamp_ns, person=None):
    """Return the foreground of an image and learn from it; a person's box is tracked."""
    mask = background.apply(image, stamp_ns)
    if mask is None:
        return None
    found = mask.copy()
    tracked = np.zeros_like(mask)
    if person is not None:
        left, top, width, height = person
        tracked[top : top + height, left : left + width] = 255
    objects = objects_in(image, background.model, found)
    background.learn(image, objects, tracked, tracked, stamp_ns)
    return found


def learned(image, rate=25, seconds=2.0):
    background = Background(BackgroundConfig())
    for index in range(int(seconds * rate) + 2):
        look(background, image, (index + 1) * SECOND // rate)
    return background, (int(seconds * rate) + 3) * SECOND // rate


def scene(seed=0, shape=(96, 128)):
    """Ground of some texture."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(60, 150, (shape[0] // 8, shape[1] // 8, 3)).astype(np.uint8)
    return cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)


def seen(ground, rng, gain=1.0, person=None):
    """Return an image of the ground, with noise and a person in a rectangle."""
    image = ground.astype(float)
    if person is not None:
        left, top, width, height = person
        image[top : top + height, left : left + width] = (200, 40, 40)
    return np.clip(np.rint(gain * (image + rng.normal(0, 2, image.shape))), 0, 255).astype(
        np.uint8
    )


def test_median_of_nine_agrees_with_numpy():
    images = np.random.default_rng(0).integers(0, 256, (9, 20, 30, 3), np.uint8)
    assert np.array_equal(median_of_nine(list(images)), np.median(images, axis=0))


@pytest.mark.parametrize('level', [0, 255])
def test_model_saturates_at_the_ends_of_the_range(level):
    background, now = learned(flat(level))
    for index in range(200):
        look(background, flat(level), now + index * SECOND // 5)
    assert (background.model == level).all()


@pytest.mark.parametrize('rate', [5, 25, 100])
def test_rate_of_learning_does_not_depend_on_the_frame_rate(rate):
    background, now = learned(flat(100), rate)
    for index in range(2 * rate):
        look(background, flat(108), now + index * SECOND // rate)
    assert 108 - background.model.max() <= 1
    assert background.model.min() > 100


def test_every_pixel_moves_one_grey_level_to_the_image_or_stays():
    rng = np.random.default_rng(0)
    model = rng.choice(np.array([0, 1, 7, 8, 9, 254, 255], np.uint8), (9, 11, 3))
    image = rng.choice(np.array([0, 8, 255], np.uint8), (9, 11, 3))
    kept = rng.choice(np.array([0, 255], np.uint8), (9, 11))
    step = np.sign(image.astype(int) - model) * (kept == 0)[..., None]
    expected = model + step
    approach(model, image, kept)
    assert np.array_equal(model, expected)


def test_shade_is_learned_and_an_object_is_not():
    ground = flat(100, (96, 128, 3))
    background, now = learned(ground)
    image = ground.copy()
    image[20:40, 20:40] = 82
    image[60:80, 60:80] = (30, 40, 200)
    for index in range(25):
        look(background, image, now + index * SECOND // 5)
    assert abs(background.model[20:40, 20:40].astype(int) - 82).max() <= 1
    assert (background.model[60:80, 60:80] == 100).all()


def test_threshold_follows_the_noise():
    rng = np.random.default_rng(1)

    def noisy(sigma):
        return np.clip(rng.normal(120, sigma, (96, 128, 3)), 0, 255).astype(np.uint8)

    quiet, loud = Background(BackgroundConfig()), Background(BackgroundConfig())
    for index in range(60):
        quiet.apply(noisy(1), index * SECOND // 25)
        loud_mask = loud.apply(noisy(8), index * SECOND // 25)
    assert quiet.threshold == BackgroundConfig().minimum_threshold
    assert loud.threshold > 25
    assert (loud_mask > 0).mean() < 0.01


def test_changed_image_is_learned_anew():
    background, now = learned(scene(1))
    assert background.apply(scene(2), now + SECOND) is None
    for index in range(30):
        mask = look(background, scene(2), now + 2 * SECOND + index * SECOND // 25)
    assert not mask.any()


@pytest.mark.parametrize('given', [True, False])
def test_who_walks_is_found_and_leaves_no_trail(given):
    ground, rng = scene(), np.random.default_rng(0)
    background = Background(BackgroundConfig())
    if given:
        background.begin(ground)
    for index in range(150):
        person = (index - 40, 30, 12, 40) if index >= 40 else None
        mask = look(background, seen(ground, rng, 1.0, person), (index + 1) * SECOND // 25)
        if 60 < index < 140:
            left = index - 40
            assert (mask[30:70, left : left + 12] > 0).mean() > 0.95
            mask[30:70, left : left + 12] = 0
            assert (mask > 0).mean() < 0.01


def test_who_walked_in_does_not_burn_in():
    ground, rng = scene(), np.random.default_rng(0)
    background = Background(BackgroundConfig(still_s=4.0))
    background.begin(ground)
    person = (50, 30, 12, 40)
    for index in range(300):
        mask = look(background, seen(ground, rng, 1.0, person), (index + 1) * SECOND // 10, person)
    assert (mask[30:70, 50:62] > 0).mean() > 0.95


@pytest.mark.parametrize(('still_s', 'shown'), [(4.0, False), (0.0, True)])
def test_what_lies_still_stays_foreground_only_if_so_configured(still_s, shown):
    ground, rng = scene(), np.random.default_rng(0)
    background = Background(BackgroundConfig(still_s=still_s))
    background.begin(ground)
    for index in range(80):
        image = seen(ground, rng, 1.0, (50, 30, 12, 40))
        mask = look(background, image, (index + 1) * SECOND // 10)
    assert bool((mask[30:70, 50:62] > 0).mean() > 0.95) == shown


@pytest.mark.parametrize('gain', [0.6, 0.7, 1.3, 1.6])
def test_a_step_of_the_gain_changes_nothing_that_is_seen(gain):
    ground, rng = scene(), np.random.default_rng(0)
    background = Background(BackgroundConfig())
    background.begin(ground)
    person = (50, 30, 12, 40)
    for index in range(100):
        factor = gain if index >= 50 else 1.0
        mask = look(
            background, seen(ground, rng, factor, person), (index + 1) * SECOND // 25, person
        )
        assert (mask[30:70, 50:62] > 0).mean() > 0.9
        mask[30:70, 50:62] = 0
        assert (mask > 0).mean() < 0.01


def test_drift_leaves_no_trace_of_who_stood_there_meanwhile():
    ground, rng = scene(), np.random.default_rng(0)
    background = Background(BackgroundConfig())
    background.begin(ground)
    for index in range(300):
        person = (50, 30, 12, 40) if index < 200 else None
        gain = 1 + 0.3 * np.sin(2 * np.pi * index / 500)
        mask = look(
            background, seen(ground, rng, gain, person), (index + 1) * SECOND // 25, person
        )
        if index >= 200:
            assert (mask > 0).mean() < 0.01


def test_a_saturated_place_is_right_again_when_it_gets_darker():
    ground, rng = scene(), np.random.default_rng(0)
    ground[40:50] = 230
    background = Background(BackgroundConfig())
    background.begin(ground)
    for index, gain in enumerate([1.0] * 10 + [1.4] * 10 + [1.0] * 10):
        mask = look(background, seen(ground, rng, gain), (index + 1) * SECOND // 25)
        assert (mask > 0).mean() < 0.01


def test_gains_are_the_medians_of_the_channels():
    old = np.random.default_rng(3).integers(40, 120, (500, 3)).astype(np.uint8)
    new = np.rint(old * [0.7, 1.0, 1.8]).astype(np.uint8)
    new[:100] = 9
    assert np.allclose(gains(new, old), [0.7, 1.0, 1.8], atol=0.01)
    assert gains(old, old).tolist() == [1, 1, 1]
    assert gains(np.zeros_like(old), old).tolist() == [1, 1, 1]
