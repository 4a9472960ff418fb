import numpy as np
import pytest

from mctrack_ros.ground import read_grid
from mctrack_ros.ground.coverage.coverage import CoverageConfig
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.web.coverage.drawing import MAPS, coverage_map, fields_drawing, fields_extent
from mctrack_ros.web.coverage.site_fields import save_fields, site_fields
from web.fields import write_site

SQUARE = [(10.0, 10.0), (30.0, 10.0), (30.0, 30.0), (10.0, 30.0)]
COARSE = CoverageConfig(cell=4.0)


@pytest.fixture
def site(tmp_path):
    return write_site(tmp_path)


@pytest.fixture
def fields(site):
    return site_fields(site, COARSE)


def draw(fields, corners):
    for corner in corners:
        fields.add(*corner)


def test_without_drawing_the_calibration_says_what_is_seen(fields):
    assert fields.drawn == {}
    assert fields.coverage.share(1) > 0.5


def test_a_drawn_field_takes_the_place_of_the_derived_one(fields):
    draw(fields, SQUARE)
    assert fields.flaws() == {}
    assert fields.coverage.fields[0].area == pytest.approx(400)
    fields.clear()
    assert fields.coverage.fields[0].area > 1000


def test_until_it_is_a_polygon_the_derived_field_counts_and_it_is_said_why(fields):
    draw(fields, SQUARE[:2])
    assert 'expected at least 3' in fields.flaws()['cam1']
    assert fields.coverage.fields[0].area > 1000


def test_a_corner_near_an_edge_divides_it(fields):
    draw(fields, SQUARE)
    fields.add(31.0, 20.0)
    assert fields.drawn['cam1'] == (*SQUARE[:2], (31.0, 20.0), *SQUARE[2:])


def test_corners_are_moved_and_removed_and_that_is_undone(fields):
    draw(fields, SQUARE)
    fields.move(2, 40.0, 40.0)
    fields.delete(0)
    assert fields.drawn['cam1'] == ((30.0, 10.0), (40.0, 40.0), (10.0, 30.0))
    fields.undo()
    fields.undo()
    assert fields.drawn['cam1'] == tuple(SQUARE)
    assert fields.coverage.fields[0].area == pytest.approx(400)
    fields.redo()
    assert fields.drawn['cam1'][2] == (40.0, 40.0)


def test_only_what_was_drawn_is_saved_and_found_again(site, fields, tmp_path):
    before = (tmp_path / 'cam1.xml').read_bytes()
    fields.choose('cam2')
    draw(fields, SQUARE)
    assert save_fields(site, fields).endswith('cam2')
    assert (tmp_path / 'cam1.xml').read_bytes() == before
    np.testing.assert_array_equal(read_grid(tmp_path / 'cam2.xml').fov, SQUARE)
    again = site_fields(site, COARSE)
    assert again.drawn == {'cam2': tuple(SQUARE)}
    again.choose('cam2')
    again.clear()
    save_fields(site, again)
    assert read_grid(tmp_path / 'cam2.xml').fov is None


def test_a_field_that_is_no_polygon_is_not_saved(site, fields):
    draw(fields, SQUARE[:2])
    with pytest.raises(FieldOfViewError, match='cam1'):
        save_fields(site, fields)


def test_an_unknown_camera_is_refused(fields):
    with pytest.raises(FieldOfViewError, match='cam9'):
        fields.choose('cam9')


def test_the_plan_shows_the_area_the_cameras_and_the_corners(fields):
    draw(fields, SQUARE)
    drawing = fields_drawing(fields)
    kinds = [line.kind for line in drawing.lines]
    assert 'area' in kinds
    assert 'blind' in kinds
    assert 'field camera0 current' in kinds
    assert [mark.name for mark in drawing.marks if mark.movable] == ['0', '1', '2', '3']
    left, top, width, height = fields_extent(fields.coverage)
    feet = fields.coverage.feet
    assert (left < feet[:, 0]).all()
    assert (-top - height < feet[:, 1]).all()
    assert left + width > 105


@pytest.mark.parametrize('kind', MAPS)
def test_a_map_covers_the_cells(fields, kind):
    found = coverage_map(fields.coverage, kind)
    assert found.png.startswith(b'\x89PNG')
    assert found.frame == (0.0, -68.0, 108.0, 68.0)
    assert found.least != found.most
