from dataclasses import replace

import numpy as np
import pytest

from mctrack_ros.perception.silhouettes import as_printed
from mctrack_ros.perception.silhouettes.background.model import LowPassBackground

PRINTED = as_printed().background
PERIOD_NS = 250_000_000
SHAPE = (48, 64)


def flat(value):
    return np.full(SHAPE, value, np.uint8)


def learned(images, config=PRINTED, period_ns=PERIOD_NS):
    background = LowPassBackground(config)
    masks = [background.apply(one, (k + 1) * period_ns) for k, one in enumerate(images)]
    return background, masks


def test_the_first_image_is_the_background():
    background, masks = learned([flat(100)])
    assert masks == [None]
    assert (background.model == 100).all()


def test_background_pixels_follow_by_beta_and_foreground_pixels_do_not():
    image = flat(110)
    image[:, 32:] = 113
    background, masks = learned([flat(100), image])
    assert (masks[1][:, :32] == 0).all()
    assert (masks[1][:, 32:] == 255).all()
    assert np.allclose(background.model[:, :32], 101.0)
    assert (background.model[:, 32:] == 100).all()


def test_a_difference_of_the_threshold_is_not_foreground():
    _, masks = learned([flat(100), flat(112)])
    assert not masks[1].any()


@pytest.mark.parametrize(('rows', 'resets'), [(28, False), (29, True)])
def test_more_than_60_per_cent_of_the_image_resets_the_background(rows, resets):
    image = flat(100)
    image[:rows] = 200
    background, masks = learned([flat(100), image])
    assert (masks[1] is None) == resets
    assert (background.model == image).all() == resets


def test_the_filter_is_the_same_at_every_rate():
    slow, _ = learned([flat(100), flat(110)])
    fast, _ = learned([flat(100)] + [flat(110)] * 10, period_ns=PERIOD_NS // 10)
    assert np.allclose(slow.model, fast.model, atol=0.01)


def test_the_threshold_follows_the_noise_if_asked_to():
    rng = np.random.default_rng(1)
    images = [rng.normal(100, 6, SHAPE).astype(np.uint8) for _ in range(40)]
    background, _ = learned(images, replace(PRINTED, threshold=5.0, threshold_sigmas=5.0))
    assert background.noise == pytest.approx(6.0, rel=0.15)
    assert background.threshold == pytest.approx(5 * background.noise)


def test_an_inserted_rectangle_is_background_and_can_be_taken_out_again():
    background, _ = learned([flat(100)])
    image, box = flat(150), np.array([10, 5, 20, 12])
    before = background.insert(image, box)
    assert (background.model[5:17, 10:30] == 150).all()
    assert (background.model == 150).sum() == 240
    inside = np.zeros((12, 20), np.uint8)
    inside[:, :7] = 255
    background.restore(before, box, inside)
    assert (background.model == 150).sum() == 240 - 84


def test_what_may_be_a_shadow_is_neither_foreground_nor_learned():
    image = flat(100)
    image[:, :10], image[:, 10:20] = 90, 80
    background, masks = learned(
        [flat(100), image], replace(PRINTED, threshold=5.0, shadow_share=0.15)
    )
    assert not masks[1][:, :10].any()
    assert masks[1][:, 10:20].all()
    assert (background.model[:, :20] == 100).all()


def test_what_is_hidden_follows_the_light_of_the_rest():
    images = [np.full(SHAPE, round(100 * 1.01**step), np.uint8) for step in range(20)]
    for image in images[1:]:
        image[:10] = 250
    background, masks = learned(images, replace(PRINTED, follow_light=True))
    assert np.allclose(background.model[:10], 119, atol=2.5)
    assert background.light == pytest.approx(1.19, abs=0.03)
    assert (masks[-1][10:] == 0).all()


def test_a_leap_of_the_light_is_followed_at_once_and_hides_nobody():
    rng = np.random.default_rng(6)
    known = rng.integers(60, 160, SHAPE).astype(np.uint8)
    shown = np.rint(known * 0.6).astype(np.uint8)
    shown[10:30, 20:30] = 200
    _, masks = learned([known, known, known, shown], replace(PRINTED, follow_light=True))
    expected = np.zeros(SHAPE, np.uint8)
    expected[10:30, 20:30] = 255
    assert np.array_equal(masks[-1], expected)


@pytest.mark.parametrize('shadow_share', [0.0, 0.13])
def test_foreground_is_what_differs_by_more_than_noise_and_shadow(shadow_share):
    rng = np.random.default_rng(4)
    known, shown = rng.integers(0, 256, (2, *SHAPE)).astype(int)
    shown = np.where(rng.random(SHAPE) < 0.8, np.clip(known + shown % 40 - 30, 0, 255), shown)
    config = replace(PRINTED, shadow_share=shadow_share)

    _, masks = learned([known.astype(np.uint8), shown.astype(np.uint8)], config)

    darkest = np.minimum(known - 12, np.rint(known * (1 - shadow_share)))
    expected = (shown > known + 12) | (shown < (darkest if shadow_share else known - 12))
    assert np.array_equal(masks[1] > 0, expected)
