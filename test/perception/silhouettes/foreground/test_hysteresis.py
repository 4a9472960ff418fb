import cv2
import numpy as np
import pytest

from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import AREA, BINS, HISTOGRAM, Shapes
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.foreground.fragment_merging import (
    FragmentMergingConfig,
    gathered,
)
from mctrack_ros.perception.silhouettes.foreground.hysteresis import with_faint

SIZE, GROUND, COAT, SKIN = (480, 640), 100, 106, 160
SMALL_PX = 60.0
NOBODY = Shapes(np.zeros((0, 21)), np.zeros((0, 4)))


@pytest.fixture
def sizes(mapping):
    return SizeTable(mapping)


@pytest.fixture
def background():
    background = Background(BackgroundConfig())
    background.noise = 1.0
    return background


def somebody(foot_row=380, left=300, shown=4):
    """Return an image of one whose coat is like the ground, and what is foreground of him."""
    grey, mask = np.full(SIZE, GROUND, np.uint8), np.zeros(SIZE, np.uint8)
    grey[foot_row - 40 : foot_row, left : left + 10] = COAT
    for row in (foot_row - 40, foot_row - shown):
        grey[row : row + shown, left : left + 10] = SKIN
        mask[row : row + shown, left : left + 10] = 255
    return grey, mask


def found(grey, mask, background, sizes, config):
    silhouettes = find_silhouettes(mask, grey, ComponentConfig(1, 1))
    background.difference = cv2.absdiff(grey, np.full_like(grey, GROUND))
    silhouettes = gathered(silhouettes, NOBODY, sizes, config)
    return silhouettes, with_faint(silhouettes, background, sizes, config, SMALL_PX)


def test_a_coat_like_the_ground_counts_between_head_and_feet(background, sizes):
    before, after = found(*somebody(shown=2), background, sizes, FragmentMergingConfig())
    assert before.shapes.area.tolist() == [40]
    assert after.shapes.area.tolist() == [400]
    assert after.shapes.vector[0, HISTOGRAM].sum() == 400
    assert after.shapes.vector[0, HISTOGRAM][COAT // (256 // BINS)] == 360
    rest = np.setdiff1d(np.arange(before.shapes.vector.shape[1]), np.r_[AREA, HISTOGRAM])
    assert (before.shapes.vector[0, rest] == after.shapes.vector[0, rest]).all()
    assert (before.shapes.box == after.shapes.box).all()


def test_a_coat_counts_only_for_who_is_small(background, sizes):
    before, after = found(*somebody(shown=4), background, sizes, FragmentMergingConfig())
    assert before.shapes.area.tolist() == after.shapes.area.tolist() == [80]


def test_what_is_no_more_than_noise_does_not_count(background, sizes):
    background.noise = 2.5
    _, after = found(*somebody(shown=2), background, sizes, FragmentMergingConfig())
    assert after.shapes.area.tolist() == [40]


def test_another_silhouette_in_the_box_keeps_its_own(background, sizes):
    grey, mask = somebody(shown=2)
    grey[352:368, 304:306] = SKIN
    mask[352:368, 304:306] = 255
    config = FragmentMergingConfig(person_height_m=0.0)  # nothing is gathered
    _, after = found(grey, mask, background, sizes, config)
    assert after.shapes.area.sum() == 40 + 32


def test_the_paper_counts_nothing_faint(background, sizes):
    before, after = found(
        *somebody(shown=2), background, sizes, FragmentMergingConfig(faint_sigmas=0.0)
    )
    assert after is before
