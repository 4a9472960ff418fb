import dataclasses
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from far_hall import write_far_hall
from mctrack_ros.cli.main import app
from mctrack_ros.ground import read_calibration, read_grid, write_grid

GRID = Path(__file__).resolve().parents[3] / 'config' / 'pitch5' / 'cam5.xml'


def run(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


def test_a_calibration_is_converted_and_its_size_is_taken_from_the_file(tmp_path):
    result = run('convert-calibration', GRID, tmp_path / 'cam5.yaml')
    assert result.exit_code == 0, result.exception
    assert 'camera_info, for images of 768 x 576 px' in result.output
    assert 'covariance of the calibration' in result.output
    result = run('convert-calibration', tmp_path / 'cam5.yaml', tmp_path / 'back.xml')
    assert result.exit_code == 0, result.exception
    assert 'covariance' not in result.output
    assert read_grid(tmp_path / 'back.xml').workstation == 'cam5'


def test_what_cannot_be_converted_is_said(tmp_path):
    assert '--to' in str(run('convert-calibration', GRID, tmp_path / 'a.txt').exception)
    (tmp_path / 'matrix.yaml').write_text('image_from_ground: [[20,1,300],[0,-8,400],[0,0.02,1]]')
    result = run('convert-calibration', tmp_path / 'matrix.yaml', tmp_path / 'a.xml')
    assert '--size' in str(result.exception)


@pytest.mark.parametrize('offset', [(389000.0, 5820000.0), (2e6, 2e6), (1e7, 1e7)])
def test_a_site_in_national_coordinates_is_checked_as_near_zero(tmp_path, offset):
    written = []
    for each in ((0.0, 0.0), offset):
        write_far_hall(tmp_path / 'hall', each)
        site = tmp_path / 'hall' / 'site.yaml'
        result = run('check-calibration', site, '--json', tmp_path / 'check.json')
        assert result.exit_code == 0, result.output
        assert 'south.yaml can be used' in result.output.replace('\n', '')
        written.append(json.loads((tmp_path / 'check.json').read_text())['north'])
    near, far = written
    assert far['accepted']
    assert near['accepted']
    for key in ('rms_px', 'left_out_rms_px', 'deviation_m'):
        assert far[key] == pytest.approx(near[key], rel=0.01)


@pytest.mark.parametrize('to', ['grid', 'camera_info', 'opencv', 'image_from_world'])
def test_a_far_calibration_is_converted_in_its_own_coordinates(tmp_path, to):
    offset = (389010.5, 5820020.25)
    write_far_hall(tmp_path, offset)
    ending = '.xml' if to == 'grid' else '.yaml'
    target, size = tmp_path / f'out{ending}', (320, 240)
    result = run('convert-calibration', tmp_path / 'south.yaml', target, '--to', to)
    assert result.exit_code == 0, result.exception
    place = read_calibration(target, size).camera_position
    assert place == pytest.approx([4.0 + offset[0], 22.0 + offset[1], 9.0], abs=5e-3)


def test_a_wrong_point_is_named_and_the_command_fails(tmp_path):
    grid = read_grid(GRID)
    wrong = grid.names[5][0]
    image = grid.image.copy()
    for cell, names in enumerate(grid.names):
        for corner, name in enumerate(names):
            if name == wrong:
                image[cell, corner] += (12.0, 5.0)
    write_grid(dataclasses.replace(grid, image=image), tmp_path / 'cam5.xml')
    result = run('check-calibration', tmp_path / 'cam5.xml', '--json', tmp_path / 'check.json')
    assert result.exit_code == 1
    assert f'point {wrong} is' in result.output
    written = json.loads((tmp_path / 'check.json').read_text())
    assert written['cam5']['suspicious'] == [wrong]
