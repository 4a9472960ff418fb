import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import ProjectiveMapping, read_grid
from mctrack_ros.simulation import CarParkScenario, Scenario, pitch5_cameras
from mctrack_ros.simulation.calibration import camera_grid, write_calibration
from mctrack_ros.simulation.carpark import carpark_cameras
from mctrack_ros.simulation.pitch.field import line_distance
from mctrack_ros.site.site import load_site

CONFIG = Path(__file__).resolve().parents[2] / 'config'
SHIPPED = CONFIG / 'pitch5'


def test_shipped_files_are_what_the_code_gives(tmp_path):
    write_calibration(Scenario(), tmp_path)
    names = ['cam1.xml', 'cam2.xml', 'cam3.xml', 'cam4.xml', 'cam5.xml', 'lines.yaml', 'scene.xml']
    assert sorted(file.name for file in tmp_path.iterdir()) == names
    for name in names:
        assert (SHIPPED / name).read_text() == (tmp_path / name).read_text(), name


def test_shipped_car_park_is_what_the_code_gives(tmp_path):
    write_calibration(CarParkScenario(), tmp_path)
    assert sorted(file.name for file in tmp_path.iterdir()) == ['cam1.xml', 'scene.xml']
    for name in ('cam1.xml', 'scene.xml'):
        assert (CONFIG / 'carpark' / name).read_text() == (tmp_path / name).read_text(), name


def test_car_park_site_agrees_with_the_simulated_camera():
    (camera,) = carpark_cameras(CarParkScenario())
    mapping = load_site(CONFIG / 'carpark.yaml').cameras['cam1'].mapping()
    pixel = np.array([(320.0, 300.0), (100.0, 200.0), (600.0, 400.0)])
    np.testing.assert_allclose(mapping.ground_from_image(pixel), camera.ground(pixel), atol=0.05)


@pytest.mark.parametrize('camera', pitch5_cameras(Scenario()), ids=lambda camera: camera.name)
def test_shipped_grids_are_clicked_with_half_a_pixel_of_noise(camera):
    ground, image = read_grid(SHIPPED / f'{camera.name}.xml').points()
    assert len(np.unique(ground, axis=0)) == len(ground)  # a point is clicked once, not per cell
    missed = image - camera.project(np.pad(ground, ((0, 0), (0, 1))))
    assert 0.4 < missed.std() < 0.6
    assert abs(missed.mean()) < 0.2


def test_ground_mapping_of_an_exact_grid_agrees_with_the_simulated_camera():
    for camera in pitch5_cameras(Scenario()):
        ground, image = camera_grid(camera).points()
        mapping = ProjectiveMapping.from_points(ground, image, camera.size)
        head = np.column_stack([ground, np.full(len(ground), 1.8)])
        expected = camera.project(head)
        np.testing.assert_allclose(mapping.image_from_ground(ground, 1.8), expected, atol=0.05)


def lined(file, origin='0,0'):
    """Return a camera's settings with a file of lines."""
    settings = load_site(CONFIG / 'pitch5.yaml').cameras['cam1']
    return dataclasses.replace(settings, lines=str(file), origin=origin)


def test_a_camera_names_the_lines_of_its_ground():
    lines = lined(SHIPPED / 'lines.yaml').painted_lines()
    place = np.concatenate(lines)
    assert line_distance(place[:, 0], place[:, 1]).max() < 1e-3
    moved = lined(SHIPPED / 'lines.yaml', '10,20').painted_lines()
    np.testing.assert_allclose(np.concatenate(moved), place - (10, 20))
    assert lined('').painted_lines() == []


@pytest.mark.parametrize('text', ['5', '[[1, 2]]', '[[[1, 2], [3]]]', '[[[.nan, 2]]]'])
def test_a_file_of_something_else_is_refused(tmp_path, text):
    file = tmp_path / 'lines.yaml'
    file.write_text(text)
    with pytest.raises(ConfigError, match='lines'):
        lined(file).painted_lines()
