import colorsys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.tracking.appearance import (
    GREY_BINS,
    HUE_BINS,
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


def test_templates_sum_to_one():
    assert np.allclose(colour_templates(*patch(RED, BLUE, WHITE, BLACK)).sum(axis=1), 1)


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


def test_box_may_reach_beyond_the_picture():
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
def test_bins_are_those_of_the_hsv_colour(colour):
    hue, grey, weight = colour_bins(*map(float, colour))
    expected_hue, saturation, value = colorsys.rgb_to_hsv(*(each / 255 for each in colour[::-1]))
    assert grey == HUE_BINS + int(value * 255 * GREY_BINS / 256 + 1e-9)
    assert weight == pytest.approx(saturation)
    turn = (expected_hue * HUE_BINS - hue) % HUE_BINS
    assert turn < 1 + 1e-9 or turn > HUE_BINS - 1e-9
