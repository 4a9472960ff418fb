import dataclasses

import numpy as np
import pytest
import shapely

from mctrack_ros.ground import read_grid
from mctrack_ros.ground.coverage.coverage import CoverageConfig, View
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.simulation import Scenario, pitch5_cameras
from mctrack_ros.web.coverage.fields import Fields
from mctrack_ros.web.coverage.seen_drawing import seen_drawing
from mctrack_ros.web.coverage.seen_field import add_seen, ground_seen, move_seen, seen_corners
from mctrack_ros.web.coverage.site_fields import save_fields, site_fields
from web.fields import write_site

CAMERA = pitch5_cameras(Scenario())[0]
SQUARE = [(10.0, 20.0), (30.0, 20.0), (30.0, 40.0), (10.0, 40.0)]


@pytest.fixture
def site(tmp_path):
    return write_site(tmp_path)


@pytest.fixture
def fields(site):
    return site_fields(site, CoverageConfig(cell=4.0))


def seen(place):
    """Return where the true camera sees a place on the ground."""
    return CAMERA.project([(*place, 0.0)])[0].tolist()


def draw(fields):
    for corner in SQUARE:
        add_seen(fields, *seen(corner))


def test_what_is_drawn_on_the_image_lies_on_the_ground(fields):
    draw(fields)
    np.testing.assert_allclose(fields.corners, SQUARE, atol=0.05)
    np.testing.assert_allclose(seen_corners(fields), [seen(c) for c in SQUARE], atol=0.1)
    assert fields.coverage.fields[0].area == pytest.approx(400, rel=0.01)


def test_a_corner_that_is_dragged_in_the_image_moves_on_the_ground(fields):
    draw(fields)
    move_seen(fields, 2, *seen((35.0, 45.0)))
    np.testing.assert_allclose(fields.corners[2], (35.0, 45.0), atol=0.1)
    fields.undo()
    np.testing.assert_allclose(fields.corners, SQUARE, atol=0.05)


def test_a_corner_divides_the_edge_that_is_nearest_in_the_image(fields):
    draw(fields)
    add_seen(fields, *seen((31.0, 30.0)))
    np.testing.assert_allclose(fields.corners[2], (31.0, 30.0), atol=0.1)


@pytest.mark.parametrize(
    ('pixel', 'reason'),
    [
        ((400, 3), 'above the horizon; nothing was changed'),
        ((400, 120), r'm away, beyond the reach of 200 m; nothing was changed'),
        ((-5, 300), 'outside the image'),
        ((float('nan'), 300), 'outside the image'),
    ],
)
def test_a_pixel_without_ground_is_refused_and_nothing_is_lost(fields, pixel, reason):
    draw(fields)
    before = fields.corners
    with pytest.raises(FieldOfViewError, match=reason):
        add_seen(fields, *pixel)
    with pytest.raises(FieldOfViewError, match=reason):
        move_seen(fields, 1, *pixel)
    assert fields.corners == before


@pytest.mark.parametrize('method', ['fitted', 'projective', 'iterated', 'homography'])
def test_the_horizon_is_found_with_every_kind_of_mapping(site, method):
    mapping = dataclasses.replace(site.cameras['cam1'], method=method).mapping()
    np.testing.assert_allclose(ground_seen(mapping, *seen((20, 34)), 200.0), (20, 34), atol=0.3)
    with pytest.raises(FieldOfViewError):
        ground_seen(mapping, 400, 3, 200.0)


def test_the_image_shows_the_fields_the_blind_ground_and_the_reach(fields):
    draw(fields)
    fields.choose_corner(1)
    drawing = seen_drawing(fields)
    kinds = {line.kind for line in drawing.lines}
    assert {'metres', 'blind', 'reach', 'field camera0 current', 'field camera1'} == kinds
    assert [mark.kind for mark in drawing.marks] == ['corner', 'chosen', 'corner', 'corner']
    outline = np.concatenate([ln.points for ln in drawing.lines if 'current' in ln.kind])
    ground = CAMERA.ground(outline)
    ring = shapely.LinearRing(fields.corners)
    assert max(shapely.distance(ring, shapely.points(ground))) < 0.05


def test_blind_ground_elsewhere_is_not_in_the_image(fields):
    draw(fields)
    blind = (shapely.box(900, 900, 901, 901),)
    fields.coverage = dataclasses.replace(fields.coverage, blind=blind)
    assert 'blind' not in {line.kind for line in seen_drawing(fields).lines}


def test_corners_behind_the_camera_are_left_out_of_its_image(fields):
    for corner in [(-60.0, -80.0), (20.0, 20.0), (20.0, 40.0)]:
        fields.add(*corner)
    assert [mark.name for mark in seen_drawing(fields).marks] == ['1', '2']
    add_seen(fields, *seen((30.0, 30.0)))
    assert len(fields.corners) == 4


def test_it_is_saved_as_the_field_of_the_grid(site, fields, tmp_path):
    draw(fields)
    save_fields(site, fields)
    np.testing.assert_allclose(read_grid(tmp_path / 'cam1.xml').fov, SQUARE, atol=0.05)


def test_a_camera_without_calibration_is_drawn_on_the_ground_alone():
    fields = Fields({'cam1': View(shapely.box(0, 0, 9, 9))}, {}, None, CoverageConfig())
    with pytest.raises(FieldOfViewError, match='cam1 is not calibrated'):
        add_seen(fields, 5, 5)
