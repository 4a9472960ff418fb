"""A site's local origin: stated, chosen, refused, and told to whom it concerns."""

import dataclasses
import json

import numpy as np
import pytest
import shapely
import yaml
from hypothesis import given
from hypothesis import strategies as st

from far_hall import write_far_hall
from mctrack_ros.config import ConfigError
from mctrack_ros.ground import read_grid, write_fov
from mctrack_ros.ground.coverage.coverage import CoverageConfig
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.coverage import site_coverage
from mctrack_ros.site.origin import FARTHEST_M, chosen_origin
from mctrack_ros.site.site import load_site
from mctrack_ros.site.stated_origin import origin_from, origin_text
from mctrack_ros.web.coverage.report import coverage_text
from mctrack_ros.web.coverage.site_fields import save_fields, site_fields

OFFSETS = [(389000.0, 5820000.0), (389123.4, 5820456.7), (2e6, 2e6), (1e7, 1e7)]
PIXELS = np.array([[160.0, 120.0], [40.0, 200.0], [300.0, 90.0]])
COARSE = CoverageConfig(cell=1.0)


@pytest.mark.parametrize('offset', OFFSETS)
def test_a_far_site_takes_whole_kilometres_near_its_cameras_for_its_origin(tmp_path, offset):
    site = write_far_hall(tmp_path, offset)
    assert site.origin == tuple(np.round(np.array(offset) / 1000) * 1000)
    assert json.loads(site.description(0))['origin'] == list(site.origin)
    near = write_far_hall(tmp_path / 'near', (0.0, 0.0))
    assert near.origin == (0.0, 0.0)
    for name, camera in site.cameras.items():
        assert origin_from(camera.origin) == site.origin
        place, covariance = camera.mapping().locate(PIXELS, np.eye(2))
        expected, spread = near.cameras[name].mapping().locate(PIXELS, np.eye(2))
        kept = place.astype(np.float32).astype(np.float64) + site.origin
        np.testing.assert_allclose(kept - offset, expected, rtol=0, atol=1e-3)
        np.testing.assert_allclose(covariance, spread, rtol=0.01)


def test_a_stated_origin_wins(tmp_path):
    site = write_far_hall(tmp_path, (389000.0, 5820000.0), origin='388500,5819000.5')
    assert site.origin == (388500.0, 5819000.5)
    foot = site.cameras['south'].mapping().camera_position[:2]
    np.testing.assert_allclose(foot, [504.0, 1021.5], atol=1e-3)
    assert write_far_hall(tmp_path, (3000.0, 0.0)).origin == (0.0, 0.0)
    assert write_far_hall(tmp_path, (3000.0, 0.0), origin='3000,0').origin == (3000.0, 0.0)


@pytest.mark.parametrize('text', ['389000', '1,2,3', 'a,b', 'inf,0', 'nan,1'])
def test_what_is_no_origin_is_refused(tmp_path, text):
    with pytest.raises(ConfigError, match='expected x,y in metres, for example 389000,5820000'):
        write_far_hall(tmp_path, (0.0, 0.0), origin=text)


def test_a_camera_has_no_origin_of_its_own(tmp_path):
    with pytest.raises(
        ConfigError, match=r'cameras\.north\.origin: the origin is one for the whole'
    ):
        write_far_hall(tmp_path, (0.0, 0.0), cameras={'north': {'origin': '1,2'}})


@pytest.mark.parametrize('name', ['north', 'south'])
def test_a_camera_far_from_its_origin_is_refused_with_the_line_to_set(tmp_path, name):
    site = write_far_hall(tmp_path, (389000.0, 5820000.0))
    alone = dataclasses.replace(site.cameras[name], origin=CameraSettings().origin)
    with pytest.raises(ConfigError, match=r'5833 km from .* 0,0, .*: set origin: 389000,5820000'):
        alone.mapping()


def test_one_camera_in_other_coordinates_is_refused_by_name(tmp_path):
    site = write_far_hall(tmp_path, (389000.0, 5820000.0))
    write_far_hall(tmp_path / 'near', (0.0, 0.0))
    content = yaml.safe_load((tmp_path / 'site.yaml').read_text())
    zoo = content['cameras']['north'] | {'grid': 'near/north.xml'}
    mixed = write_far_hall(
        tmp_path, (389000.0, 5820000.0), cameras=content['cameras'] | {'zoo': zoo}
    )
    assert mixed.origin == site.origin
    with pytest.raises(ConfigError, match=r'near/north\.xml: the camera is at'):
        mixed.cameras['zoo'].mapping()


def test_a_camera_that_cannot_be_read_is_refused_when_it_is_used(tmp_path):
    write_far_hall(tmp_path, (389000.0, 5820000.0))
    (tmp_path / 'south.yaml').write_text('nothing: 1\n')
    site = load_site(tmp_path / 'site.yaml')
    assert site.origin == (389000.0, 5820000.0)
    with pytest.raises(ValueError, match=r'south\.yaml'):
        site.cameras['south'].mapping()


@given(st.lists(st.tuples(*[st.floats(-1e7, 1e7)] * 2), min_size=1, max_size=5))
def test_a_chosen_origin_reads_back_and_is_near_the_middle_camera(places):
    origin = chosen_origin(np.array(places))
    assert origin_from(origin_text(origin)) == origin
    middle = np.median(np.array(places), axis=0)
    assert np.abs(middle - origin).max() <= FARTHEST_M


@pytest.mark.parametrize('offset', OFFSETS)
def test_coverage_is_told_in_the_coordinates_of_the_files(tmp_path, offset):
    near = site_coverage(write_far_hall(tmp_path / 'near', (0.0, 0.0)), COARSE)
    far = site_coverage(write_far_hall(tmp_path / 'far', offset), COARSE)
    np.testing.assert_allclose(
        np.reshape(far.area.bounds, (2, 2)) - offset,
        np.reshape(near.area.bounds, (2, 2)),
        atol=1e-6,
    )
    assert far.share(1) == pytest.approx(near.share(1), abs=1e-5)
    assert far.share(2) == pytest.approx(near.share(2), abs=1e-5)
    np.testing.assert_allclose(far.feet - offset, near.feet, atol=1e-3)
    assert len(far.blind) == len(near.blind)
    np.testing.assert_allclose(far.raster.fused, near.raster.fused, rtol=0.01)
    np.testing.assert_allclose(far.raster.origin - offset, near.raster.origin, atol=1e-6)


@pytest.mark.parametrize('offset', OFFSETS[:3])
def test_fields_are_drawn_and_saved_in_the_coordinates_of_the_files(tmp_path, offset):
    site = write_far_hall(tmp_path, offset)
    drawn = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.125]]) + offset
    write_fov(drawn, site.cameras['north'].grid)
    fields = site_fields(site, COARSE)
    np.testing.assert_array_equal(fields.drawn['north'], drawn)
    assert fields.coverage.fields[0].equals(shapely.Polygon(drawn))
    fields.choose('north')
    fields.move(0, offset[0] - 5.0, offset[1] - 4.5)
    assert 'of the area is seen' in coverage_text(fields)
    assert save_fields(site, fields) == 'Saved into the grids of north'
    drawn[0] = offset[0] - 5.0, offset[1] - 4.5
    np.testing.assert_allclose(read_grid(site.cameras['north'].grid).fov, drawn, atol=1e-3)
