"""Where people are looked for, and what they cover there."""

import numpy as np
import pytest
import shapely

from drawn_hall import SIZE
from masks import AREA, MAPPINGS
from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.occupancy import scene as module
from mctrack_ros.fusion.occupancy.config import PeopleConfig
from mctrack_ros.fusion.occupancy.scene import LEAST_HEIGHT_PX, LEAST_SEEN, MARGIN_M, Scene
from mctrack_ros.fusion.views import Views
from mctrack_ros.ground.coverage.coverage import area_from

NAMES = tuple(MAPPINGS)


def scene(area=AREA, names=NAMES, **config):
    return Scene(Views(MAPPINGS, area_from(area) if area else None), names, PeopleConfig(**config))


@pytest.mark.parametrize('divisor', [1, 3])
def test_a_box_spans_from_feet_to_head_and_is_as_wide_as_a_person(divisor):
    where = scene()
    shape = (SIZE[1] // divisor, SIZE[0] // divisor)
    boxes = where.places(3 * (shape,)).boxes
    scale = np.tile(np.array(shape[::-1]) / SIZE, 2)
    assert boxes.shape == (3, len(where.position), 4)
    for mapping, own in zip(MAPPINGS.values(), boxes):
        foot, head = (mapping.image_from_ground(where.position, height) for height in (0.0, 1.8))
        middle = (foot[:, 0] + head[:, 0]) / 2
        half = mapping.width_px(where.position, 0.25)
        ideal = np.column_stack([middle - half, head[:, 1], middle + half, foot[:, 1]]) * scale
        is_inside = (ideal[:, :2] >= 0).all(axis=1)
        is_inside &= (ideal[:, 2:] <= np.array(shape[::-1])).all(axis=1)
        assert is_inside.sum() > 100
        assert np.abs(own - ideal)[is_inside].max() <= 0.75
        assert (own[:, :2] >= 0).all()
        assert (own[:, 2:] <= np.array(shape[::-1])).all()


def test_who_is_too_little_in_an_image_covers_nothing_there():
    where = scene(area='')
    for mapping, own in zip(MAPPINGS.values(), where.places(3 * (SIZE[::-1],)).boxes):
        left, top, right, bottom = own.T.astype(float)
        shown = right > left
        full = mapping.width_px(where.position, 0.5) * mapping.height_px(where.position, 1.8)
        share = (right - left) * (bottom - top) / full
        assert 0 < shown.sum() < len(own)
        assert share[shown].min() > 0.8 * LEAST_SEEN
        height = mapping.height_px(where.position, 1.8)
        assert height[shown].min() >= LEAST_HEIGHT_PX
    assert (where.places(3 * (SIZE[::-1],)).boxes[..., 2] > 0).any(axis=0).all()


def test_cells_lie_in_the_area_and_its_margin():
    where = scene(cell=0.25)
    beyond = shapely.distance(shapely.points(where.position), area_from(AREA))
    assert 0.7 * MARGIN_M < beyond.max() <= MARGIN_M + 1e-9
    assert (np.diff(where.position[:, 1]) >= 0).all()
    assert np.unique(np.diff(np.unique(where.position[:, 0]).round(9)).round(9)) == [0.25]
    assert where.step == 0.25


def test_without_an_area_cells_lie_wherever_people_are_large_enough():
    everywhere = scene(area='', cell=0.5)
    assert len(everywhere.position) > 2 * len(scene(cell=0.5).position)
    for x, y in ((0.0, 0.0), (4.0, 0.0), (-4.0, -1.0)):
        assert np.linalg.norm(everywhere.position - (x, y), axis=1).min() < 0.5


def test_a_large_scene_has_wider_cells(monkeypatch):
    monkeypatch.setattr(module, 'MOST_CELLS', 400)
    where = scene()
    assert len(where.position) < 450
    assert where.step == pytest.approx(6.0 / 20)


def test_masks_may_change_their_size_or_be_unknown():
    where = scene()
    full = where.places(3 * ((60, 80),)).boxes.copy()
    one_unknown = where.places(((0, 0), (60, 80), (60, 80))).boxes
    assert not one_unknown[0].any()
    np.testing.assert_array_equal(one_unknown[1:], full[1:])
    np.testing.assert_array_equal(where.places(3 * ((60, 80),)).boxes, full)


def test_an_area_that_no_camera_sees_is_refused():
    with pytest.raises(ConfigError, match='no camera sees'):
        scene(area='200,200,202,202')
