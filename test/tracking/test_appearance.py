import colorsys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.tracking.appearance import (
    MIXED,
    PALETTES,
    bhattacharyya_distance,
    colour_bins,
    colour_templates,
)

RED, BLUE, WHITE, BLACK = (30, 30, 220), (220, 60, 30), (250, 250, 250), (5, 5, 5)


def patch(*colours):
    image = np.zeros((10, 10 * len(colours), 3), np.uint8)
    for index, colour in enumerate(colours):
        image[:, 10 * index : 10 * index + 10] = colour
    boxes = np.array([[10 * index, 0, 10, 10] for index in range(len(colours))])
    return image, np.full(image.shape[:2], 255, np.uint8), boxes


@pytest.fixture(params=PALETTES)
def palette(request):
    return PALETTES[request.param]


def test_templates_sum_to_one(palette):
    templates = colour_templates(*patch(RED, BLUE, WHITE, BLACK), palette)
    assert np.allclose(templates.sum(axis=1), 1)


def test_a_palette_fits_into_a_template(palette):
    assert palette.hues + palette.greys <= TEMPLATE_SIZE


def test_only_what_counts_brightness_tells_light_from_dark_of_one_hue():
    for name, palette in PALETTES.items():
        light = colour_templates(*patch(RED), palette)
        dark = colour_templates(*patch(tuple(each // 2 for each in RED)), palette)
        far = bhattacharyya_distance(light, dark)[0, 0]
        assert far < 0.1 if name == 'hue' else far > 0.5


def test_only_foreground_counts():
    image, mask, _ = patch(RED, BLUE)
    mask[:, 10:] = 0
    both, red = colour_templates(image, mask, np.array([[0, 0, 20, 10], [0, 0, 10, 10]]))
    assert np.array_equal(both, red)


def test_box_without_foreground_has_no_template():
    image, mask, boxes = patch(RED, BLUE)
    mask[:, 10:] = 0
    assert not colour_templates(image, mask, boxes)[1].any()
    assert not colour_templates(image, np.zeros_like(mask), boxes).any()


def test_box_may_reach_beyond_the_image():
    image, mask, _ = patch(RED)
    inside, beyond = colour_templates(image, mask, np.array([[0, 0, 10, 10], [-5, -5, 30, 30]]))
    assert np.array_equal(inside, beyond)


def test_same_colours_are_near_and_others_far():
    distance = bhattacharyya_distance(*[colour_templates(*patch(RED, BLUE, WHITE, BLACK))] * 2)
    assert np.allclose(np.diag(distance), 0, atol=1e-6)
    assert distance[~np.eye(4, dtype=bool)].min() > 0.7
    assert np.allclose(distance, distance.T)


def test_nothing_is_known_of_an_empty_template():
    known = colour_templates(*patch(RED))
    assert bhattacharyya_distance(known, np.zeros((1, 48))) == pytest.approx(0.5)


@given(st.lists(st.integers(0, 255), min_size=3, max_size=3))
@settings(deadline=None)
def test_bins_are_those_of_hue_and_brightness(colour):
    hue, grey, weight = colour_bins(MIXED, *map(float, colour))
    expected_hue, saturation, _ = colorsys.rgb_to_hsv(*(each / 255 for each in colour[::-1]))
    brightness = np.dot(colour, [0.114, 0.587, 0.299]) * MIXED.greys / 256
    assert -1e-6 < brightness - (grey - MIXED.hues) < 1 + 1e-6
    assert weight == pytest.approx(MIXED.hue_share * saturation)
    turn = (expected_hue * MIXED.hues - hue) % MIXED.hues
    assert turn < 1 + 1e-9 or turn > MIXED.hues - 1e-9


@pytest.mark.parametrize('palette', PALETTES.values(), ids=PALETTES)
def test_pixels_count_in_their_bins_whether_grey_or_not(palette):
    image = np.random.default_rng(1).integers(0, 256, (12, 5, 3), np.uint8)
    image[::2, :, 1:] = image[::2, :, :1]  # grey rows
    expected = np.zeros(48)
    for row, column in np.ndindex(12, 5):
        hue, grey, weight = colour_bins(palette, *image[row, column].astype(float))
        expected[hue] += weight / 60
        expected[grey] += (1 - weight) / 60
    mask = np.full((12, 5), 255, np.uint8)
    found = colour_templates(image, mask, np.array([[0, 0, 5, 12]]), palette)
    np.testing.assert_allclose(found[0], expected, atol=1e-12)
