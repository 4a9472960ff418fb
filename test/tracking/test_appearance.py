import colorsys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.tracking.appearance import (
    GREYS,
    HALF,
    HUES,
    NO_BALANCE,
    balance_of,
    bhattacharyya_distance,
    colour_bins,
    colour_shares,
    colour_templates,
)

RED, BLUE, WHITE, BLACK = (30, 30, 220), (220, 60, 30), (250, 250, 250), (5, 5, 5)


def patch(*colours):
    image = np.zeros((10, 10 * len(colours), 3), np.uint8)
    for index, colour in enumerate(colours):
        image[:, 10 * index : 10 * index + 10] = colour
    boxes = np.array([[10 * index, 0, 10, 10] for index in range(len(colours))])
    return image, np.full(image.shape[:2], 255, np.uint8), boxes


def test_templates_sum_to_one():
    templates = colour_templates(*patch(RED, BLUE, WHITE, BLACK))
    assert np.allclose(templates.sum(axis=1), 1)


def test_light_and_dark_of_one_hue_are_alike_and_of_grey_are_not():
    def distance(colour):
        light = colour_templates(*patch(colour))
        dark = colour_templates(*patch(tuple(each // 2 for each in colour)))
        return bhattacharyya_distance(light, dark)[0, 0]

    assert distance(RED) < 0.4
    assert distance(WHITE) > 0.9


def test_a_shirt_is_not_trousers_of_its_colour():
    image, mask, _ = patch(RED, BLUE)
    upright = np.ascontiguousarray(image.transpose(1, 0, 2)), mask.T.copy()
    box = np.array([[0, 0, 10, 20]])
    one = colour_templates(*upright, box)
    other = colour_templates(upright[0][::-1].copy(), upright[1], box)
    assert bhattacharyya_distance(one, other)[0, 0] > 0.6
    np.testing.assert_allclose(one[:, :HALF], other[:, HALF:])


def test_cameras_of_other_light_see_the_same_colours_by_their_balance():
    random = np.random.default_rng(4)
    background = random.integers(40, 160, (96, 96, 3), np.uint8)
    image, mask, boxes = patch(RED, BLUE, WHITE, BLACK)
    light = np.array([1.0, 0.8, 0.6])
    seen = (image * light).astype(np.uint8), mask, boxes
    as_it_is = colour_templates(image, mask, boxes, balance_of(background))
    balanced = colour_templates(*seen, balance_of((background * light).astype(np.uint8)))
    assert np.diag(bhattacharyya_distance(as_it_is, balanced)).max() < 0.25
    assert np.diag(bhattacharyya_distance(as_it_is, colour_templates(*seen))).max() > 0.6


def test_the_smallest_background_has_a_balance():
    background = np.full((4, 6, 3), (64, 128, 0), np.uint8)
    np.testing.assert_allclose(balance_of(background), [2.0, 1.0, 128.0])


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
    inside, beyond = colour_templates(image, mask, np.array([[0, 0, 10, 10], [-5, -5, 20, 20]]))
    np.testing.assert_allclose(inside[:HALF] + inside[HALF:], beyond[:HALF] + beyond[HALF:])


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
def test_a_colour_lies_between_the_bins_of_its_hue_and_of_its_brightness(colour):
    bins, shares = colour_shares(NO_BALANCE, *map(float, colour))
    hue, saturation, _ = colorsys.rgb_to_hsv(*(each / 255 for each in colour[::-1]))
    level = np.clip(np.dot(colour, [0.114, 0.587, 0.299]) * GREYS / 256 - 0.5, 0, GREYS - 1)
    assert sum(shares) == pytest.approx(1)
    assert min(shares) >= 0
    assert shares[0] + shares[1] == pytest.approx(saturation)
    assert bins[1] == (bins[0] + 1) % HUES
    assert bins[3] == bins[2] + 1 < HALF
    if saturation > 0:
        turn = bins[0] + shares[1] / saturation - hue * HUES
        assert (turn + 1) % HUES == pytest.approx(1)
    if saturation < 1:
        lighter = shares[3] / (1 - saturation)
        assert bins[2] - HUES + lighter == pytest.approx(level)
    hard = colour_bins(NO_BALANCE, *map(float, colour))
    assert hard[0] == bins[0]
    assert hard[1] in bins[2:]


def test_pixels_count_in_the_bins_of_their_halves_whether_grey_or_not():
    image = np.random.default_rng(1).integers(0, 256, (12, 5, 3), np.uint8)
    image[::2, :, 1:] = image[::2, :, :1]  # grey rows
    expected = np.zeros((2, HALF))
    for row, column in np.ndindex(12, 5):
        bins, shares = colour_shares(NO_BALANCE, *image[row, column].astype(float))
        upper = np.interp((row + 0.5) / 12, [0.35, 0.65], [1, 0])
        expected[0, list(bins)] += upper * np.array(shares) / 60
        expected[1, list(bins)] += (1 - upper) * np.array(shares) / 60
    mask = np.full((12, 5), 255, np.uint8)
    found = colour_templates(image, mask, np.array([[0, 0, 5, 12]]))
    np.testing.assert_allclose(found[0], expected.ravel(), atol=1e-12)


def test_a_small_change_of_brightness_is_a_small_change_of_the_template():
    shades = [(level, level, level) for level in range(100, 160, 4)]
    templates = colour_templates(*patch(*shades))
    assert np.diag(bhattacharyya_distance(templates[:-1], templates[1:])).max() < 0.35
