"""What the cameras of a whole site see."""

import dataclasses

import numpy as np
import pytest
import shapely
import yaml

from lens_cameras import SIZE, camera
from mctrack_ros.ground import read_grid, write_calibration, write_grid
from mctrack_ros.ground.coverage.coverage import CoverageConfig
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.resources import config_file
from mctrack_ros.site.coverage import camera_view, site_coverage
from mctrack_ros.site.site import load_site

COARSE = CoverageConfig(cell=2.0)


@pytest.fixture(scope='module')
def pitch5():
    return load_site(config_file('pitch5.yaml'))


def test_shipped_pitch_has_no_blind_spot_and_mostly_two_cameras(pitch5):
    coverage = site_coverage(pitch5, COARSE)
    assert coverage.area.equals(shapely.box(0, 0, 105, 68))
    assert coverage.blind == ()
    assert coverage.share(1) == pytest.approx(1.0)
    assert 0.9 < coverage.share(2) < 1.0
    assert 0.05 < np.nanmedian(coverage.raster.fused) < np.nanmedian(coverage.raster.best) < 0.6


def test_given_area_takes_the_place_of_the_site_s(pitch5):
    assert site_coverage(pitch5, COARSE, '0,0,20,10').area.area == 200.0
    with pytest.raises(FieldOfViewError, match='the area crosses'):
        site_coverage(pitch5, COARSE, '0,0,9,9,9,0,0,5')


def test_noise_is_that_of_the_camera_s_pipeline(tmp_path, pitch5):
    content = yaml.safe_load(config_file('pitch5.yaml').read_text())
    content['pipeline'] = {'filter': {'foot_noise_px': 3.0, 'foot_noise_share': 0.0}}
    content['cameras'] = {'cam1': {'grid': pitch5.cameras['cam1'].grid}}
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
    view = camera_view(load_site(tmp_path / 'site.yaml').cameras['cam1'])
    assert (view.foot_noise_px, view.foot_noise_share) == (3.0, 0.0)
    place = view.field.representative_point().coords[0]
    expected = view.mapping.ground_covariance([place], 9.0 * np.eye(2))
    assert view.covariance(np.array([place])) == pytest.approx(expected)


@pytest.mark.parametrize('method', ['cell', 'iterated', 'homography'])
def test_every_grid_method_sees_about_the_same_inside_its_grid(tmp_path, pitch5, method):
    content = yaml.safe_load(config_file('pitch5.yaml').read_text())
    content['cameras'] = {'cam5': {'grid': pitch5.cameras['cam5'].grid, 'method': method}}
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
    coverage = site_coverage(load_site(tmp_path / 'site.yaml'), COARSE)
    fitted = camera_view(pitch5.cameras['cam5']).field.intersection(coverage.area)
    seen = coverage.at_least[0]
    assert seen.symmetric_difference(fitted).area < 0.02 * fitted.area


def test_polygon_in_the_grid_file_is_the_field_of_view(tmp_path, pitch5):
    settings = pitch5.cameras['cam1']
    corners = np.array([[10.0, 10.0], [40.0, 10.0], [20.0, 50.0]])
    grid = dataclasses.replace(read_grid(settings.grid), fov=corners)
    write_grid(grid, tmp_path / 'cam1.xml')
    view = camera_view(dataclasses.replace(settings, grid=str(tmp_path / 'cam1.xml')))
    assert view.field.equals(shapely.Polygon(corners))


def test_camera_that_sees_no_ground_near_enough_is_part_of_the_site(tmp_path):
    sky = camera((0, 0, 5), (0, 10, 7.0), focal=1300.0, distortion=np.zeros(5))
    hall = camera((0, -15, 8), (10, 5, 0))
    size = {'image_width': SIZE[0], 'image_height': SIZE[1]}
    content = {'area': '0,0,20,10', 'cameras': {}}
    for name, mapping in (('sky', sky), ('hall', hall)):
        write_calibration(mapping, tmp_path / f'{name}.yaml', 'camera_info', name)
        content['cameras'][name] = {'calibration': f'{name}.yaml', **size}
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
    coverage = site_coverage(load_site(tmp_path / 'site.yaml'), COARSE)
    areas = dict(zip(coverage.names, (field.area for field in coverage.fields)))
    assert areas['sky'] == 0.0
    assert areas['hall'] > 100.0
