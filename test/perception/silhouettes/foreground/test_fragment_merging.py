import numpy as np
import pytest

from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import Shapes
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.foreground.fragment_merging import (
    FragmentMergingConfig,
    gathered,
)

BOTTOM = 380
NOBODY = Shapes(np.zeros((0, 21)), np.zeros((0, 4)))


@pytest.fixture(scope='module')
def sizes(mapping):
    return SizeTable(mapping)


@pytest.fixture(scope='module')
def metre(sizes):
    """Return pixels across and upright of a metre where the things stand."""
    return sizes.per_metre(np.array([[320.0, BOTTOM]]))[0]


def drawn(parts, metre):
    """Return silhouettes of (left, bottom, width, height), m."""
    mask = np.zeros((480, 640), np.uint8)
    for left, bottom, width, height in parts:
        x, wide = round(320 + left * metre[0]), round(width * metre[0])
        low = round(BOTTOM - bottom * metre[1])
        mask[low - round(height * metre[1]) : low, x : x + wide] = 255
    return find_silhouettes(mask, mask, ComponentConfig(opening_px=1, closing_px=1))


def boxes_after(parts, metre, sizes, known=None, config=None):
    found = gathered(
        drawn(parts, metre), known or NOBODY, sizes, config or FragmentMergingConfig()
    )
    assert found.shapes.area.sum() == (found.labels > 0).sum()
    assert set(found.row_of[1:].tolist()) == set(range(len(found.shapes)))
    return found.shapes.box


def test_head_belt_and_shoes_are_one_person(metre, sizes):
    parts = [(0, 1.5, 0.25, 0.25), (-0.1, 0.9, 0.5, 0.2), (0, 0, 0.4, 0.15)]
    assert len(boxes_after(parts, metre, sizes)) == 1
    assert (
        len(boxes_after(parts, metre, sizes, config=FragmentMergingConfig(person_height_m=0.0)))
        == 3
    )


def test_two_people_apart_stay_two(metre, sizes):
    assert len(boxes_after([(0, 0, 0.5, 1.7), (1.7, 0, 0.5, 1.7)], metre, sizes)) == 2


def test_two_people_who_come_side_by_side_are_one_object(metre, sizes):
    pair = [(0, 0, 0.5, 1.7), (0.8, 0, 0.5, 1.7)]
    assert len(boxes_after(pair, metre, sizes)) == 1


def test_two_people_who_were_known_apart_stay_two(metre, sizes):
    pair = [(0, 0, 0.5, 1.7), (0.8, 0, 0.5, 1.7)]
    assert len(boxes_after(pair, metre, sizes, drawn(pair, metre).shapes)) == 2


def test_parts_of_a_vehicle_are_one_if_they_nearly_touch(metre, sizes):
    near, far = [(0, 0, 2.0, 0.7), (0.2, 0.85, 1.6, 0.6)], [(0, 0, 1.8, 1.2), (3.1, 0, 1.8, 1.2)]
    assert len(boxes_after(near, metre, sizes)) == 1
    assert len(boxes_after(far, metre, sizes)) == 2
