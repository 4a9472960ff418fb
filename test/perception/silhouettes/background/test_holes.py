import numpy as np
import pytest

from mctrack_ros.perception.silhouettes.background.holes import (
    HoleConfig,
    patched,
    without_still_holes,
)
from mctrack_ros.perception.silhouettes.background.model import LowPassBackground, LowPassConfig
from mctrack_ros.perception.silhouettes.background.stationarity import Stationarity
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)

SIZE = (60, 120)
BOX = np.s_[20:44, 30:70]
BESIDE = np.s_[20:44, 70:100]
COMPONENTS = ComponentConfig(1, 1)


@pytest.fixture
def ground():
    return np.random.default_rng(0).normal(100, 1, SIZE).astype(np.uint8)


def with_box(ground, window, grey=60):
    image = ground.copy()
    image[window] = grey
    return image


def background_of(image):
    background = LowPassBackground(LowPassConfig())
    background.restart_from(image)
    return background


def difference(image, background):
    return np.where(np.abs(image - background.model) > 12, 255, 0).astype(np.uint8)


def test_a_hole_is_patched_and_left_out(ground):
    background = background_of(with_box(ground, BOX))
    found = find_silhouettes(difference(ground, background), ground, COMPONENTS)

    left = patched(found, background, HoleConfig())

    assert len(found.shapes) == 1
    assert len(left.shapes) == 0
    assert np.abs(background.model - ground).max() <= 12


def test_a_thing_is_not(ground):
    background, image = background_of(ground), with_box(ground, BOX)
    found = find_silhouettes(difference(image, background), image, COMPONENTS)

    assert len(patched(found, background, HoleConfig()).shapes) == 1
    assert (background.model == ground).all()


def test_as_printed_holes_are_not_looked_for(ground):
    background = background_of(with_box(ground, BOX))
    found = find_silhouettes(difference(ground, background), ground, COMPONENTS)

    assert len(patched(found, background, HoleConfig(edge_ratio=0.0)).shapes) == 1


def test_a_hole_that_touches_what_moves_is_patched_when_it_has_been_still(ground):
    background, still = background_of(with_box(ground, BOX)), Stationarity(0.2)
    areas = []
    for index in range(8):
        image = with_box(ground, BESIDE, grey=130 + 20 * (index % 2))
        mask, stamp_ns = difference(image, background), index * 250_000_000
        still.watch(image, mask, stamp_ns, 7.0)
        kept = without_still_holes(mask, image, still, background, COMPONENTS, HoleConfig())
        areas.append(int((kept[BOX] > 0).sum()))
        assert (kept[20:44, 72:100] > 0).all()

    assert areas[:4] == [40 * 24] * 4
    assert areas[-1] == 0
    assert np.abs(background.model[20:44, 30:68] - ground[20:44, 30:68]).max() <= 12
