"""The mask that a camera tells."""

import numpy as np
import pytest

from mctrack_ros.interfaces import Detections, Foreground
from mctrack_ros.perception.foreground import NARROWEST_PX, PERSON_M, PERSON_PX, Reduction

RED = (30, 30, 220)


@pytest.fixture(scope='module')
def reduction(mapping):
    return Reduction(mapping, 1.0)


def test_a_person_of_the_middle_keeps_some_rows(mapping, reduction):
    mask = np.zeros(mapping.image_size[::-1], np.uint8)
    reduced = reduction.foreground(mask, 5)
    factor = mapping.image_size[0] / reduced.mask.shape[1]
    assert mapping.height_px([[0.0, 0.0]], PERSON_M)[0] / factor >= 0.8 * PERSON_PX
    assert reduced.mask.shape[1] >= NARROWEST_PX
    assert (reduced.stamp_ns, len(reduced)) == (5, 0)


def test_half_of_a_pixel_makes_it_foreground(mapping):
    reduction = Reduction(mapping, 1.0)
    reduction._factor = 4
    mask = np.zeros((240, 320), np.uint8)
    mask[40:48, 80:82] = 255  # half of two pixels
    mask[100:104, 200:201] = 255  # a quarter of one
    found = reduction.foreground(mask, 0).mask
    assert found.shape == (60, 80)
    assert np.argwhere(found).tolist() == [[10, 20], [11, 20]]


def test_masks_are_reduced_less_when_they_are_small_already(mapping):
    mask = np.zeros((120, 160), np.uint8)
    assert Reduction(mapping, 2.0).foreground(mask, 0).mask.shape[1] >= NARROWEST_PX
    assert Reduction(mapping, 100.0).foreground(mask, 0).mask.shape == (120, 160)


def test_a_camera_tells_where_people_are(stage, mapping):
    output = stage.show([((1.0, 1.0), RED)])
    mask = output.messages[Foreground.TOPIC].mask
    scale = mask.shape[1] / mapping.image_size[0]
    x, y = mapping.image_from_ground([[1.0, 1.0]], 0.9)[0] * scale
    rows, columns = np.nonzero(mask)
    assert (rows.mean(), columns.mean()) == pytest.approx((y, x), abs=2.0)
    assert output.messages[Detections.TOPIC].stamp_ns == output.messages[Foreground.TOPIC].stamp_ns
    assert len(stage.show([]).messages[Foreground.TOPIC]) == 0
