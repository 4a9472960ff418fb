import numpy as np
import pytest

from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.reference_update.holes import (
    HoleConfig,
    patched,
    without_still_holes,
)
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Stationarity

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


def coloured(grey):
    return np.repeat(grey[..., None], 3, axis=2)


def background_of(grey):
    background = Background(BackgroundConfig())
    background.begin(coloured(grey))
    return background


def apart(grey, background):
    return np.abs(coloured(grey).astype(int) - background.model).max(axis=2)


def difference(grey, background):
    return np.where(apart(grey, background) > 12, 255, 0).astype(np.uint8)


def test_a_hole_is_patched_and_left_out(ground):
    background = background_of(with_box(ground, BOX))
    found = find_silhouettes(difference(ground, background), ground, COMPONENTS)

    left = patched(found, coloured(ground), background, HoleConfig())

    assert len(found.shapes) == 1
    assert len(left.shapes) == 0
    assert apart(ground, background).max() <= 12


def test_a_thing_is_not(ground):
    background, image = background_of(ground), with_box(ground, BOX)
    found = find_silhouettes(difference(image, background), image, COMPONENTS)

    left = patched(found, coloured(image), background, HoleConfig())

    assert len(left.shapes) == 1
    assert not apart(ground, background).any()


def test_as_printed_holes_are_not_looked_for(ground):
    background = background_of(with_box(ground, BOX))
    found = find_silhouettes(difference(ground, background), ground, COMPONENTS)

    left = patched(found, coloured(ground), background, HoleConfig(edge_ratio=0.0))

    assert len(left.shapes) == 1


def test_a_hole_that_touches_what_moves_is_patched_when_it_has_been_still(ground):
    background, still = background_of(with_box(ground, BOX)), Stationarity(0.2)
    areas = []
    for index in range(8):
        image = with_box(ground, BESIDE, grey=130 + 20 * (index % 2))
        mask, stamp_ns = difference(image, background), index * 250_000_000
        still.watch(coloured(image), mask, stamp_ns, 7.0)
        kept = without_still_holes(
            mask, image, coloured(image), still, background, COMPONENTS, HoleConfig()
        )
        areas.append(int((kept[BOX] > 0).sum()))
        assert (kept[20:44, 72:100] > 0).all()

    assert areas[:4] == [40 * 24] * 4
    assert areas[-1] == 0
    assert apart(ground, background)[20:44, 30:68].max() <= 12
