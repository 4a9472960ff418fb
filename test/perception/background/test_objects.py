"""Which foreground is more than a change of light."""

import numpy as np
import pytest

from mctrack_ros.perception.background.objects import DARK_LEVEL, objects_in

FLOOR = np.array([90.0, 120.0, 140.0])
PLACE = np.s_[40:80, 60:90]


def floor(level=1.0):
    grain = np.random.default_rng(2).normal(0, 3, (120, 160, 1))
    return np.clip(FLOOR * level + grain, 0, 255).astype(np.uint8)


def scaled(image, factor):
    """Return an image in so much light, as logarithms see it."""
    bright = (image.astype(float) + DARK_LEVEL) * factor - DARK_LEVEL
    return np.clip(np.rint(bright), 0, 255).astype(np.uint8)


def share(image, background):
    """Return the share of the place that is an object, all of it foreground."""
    foreground = np.zeros(image.shape[:2], np.uint8)
    foreground[PLACE] = 255
    found = objects_in(image, background, foreground)
    assert not found[foreground == 0].any()
    assert set(np.unique(found).tolist()) <= {0, 255}
    return (found[PLACE] > 0).mean()


def with_place(background, changed):
    image = background.copy()
    image[PLACE] = changed[PLACE]
    return image


@pytest.mark.parametrize(
    ('factor', 'expected'), [(0.75, 0.0), (1.15, 0.0), (0.5, 1.0), (1.4, 1.0)]
)
def test_shade_and_reflections_are_none_but_far_darker_or_brighter_is(factor, expected):
    background = floor()
    image = with_place(background, scaled(background, factor))
    assert share(image, background) == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize('colour', [(150, 120, 90), (60, 150, 140), (90, 90, 190)])
def test_another_colour_of_the_same_brightness_is_an_object(colour):
    background = floor()
    image = background.copy()
    image[PLACE] = colour
    assert share(image, background) > 0.98


@pytest.mark.parametrize('gain', [(0.8, 0.8, 0.8), (1.2, 1.2, 1.2), (1.1, 1.0, 0.9)])
def test_light_that_changes_everywhere_is_none_and_hides_nobody(gain):
    background = floor()
    lit = scaled(background, np.array(gain))
    assert share(lit, background) == 0.0
    assert share(with_place(lit, scaled(lit, 0.5)), background) > 0.98


def test_the_noise_of_dark_pixels_is_none():
    rng = np.random.default_rng(4)
    night = np.full((120, 160, 3), 3, np.uint8)
    assert share(night + rng.integers(0, 2, night.shape).astype(np.uint8), night) == 0.0
    lamp = night.copy()
    lamp[PLACE] = 60
    assert share(lamp, night) == 1.0


def test_foreground_all_over_is_judged_as_it_is():
    background = floor()
    everywhere = np.full(background.shape[:2], 255, np.uint8)
    assert objects_in(scaled(background, 0.5), background, everywhere).all()
    assert not objects_in(scaled(background, 0.8), background, everywhere).any()


def test_nothing_is_taken_for_shade_where_there_are_no_colours():
    background = np.full((96, 128, 3), 120, np.uint8)
    image = background.copy()
    image[20:40, 20:60] = 95
    foreground = np.zeros((96, 128), np.uint8)
    foreground[20:40, 20:60] = 255
    np.testing.assert_array_equal(objects_in(image, background, foreground), foreground)
    image[60:, 60:] = (90, 120, 140)
    assert not objects_in(image, background, foreground).any()
