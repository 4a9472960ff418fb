import json

import cv2
import pytest
from typer.testing import CliRunner

from far_hall import write_far_hall
from mctrack_ros.cli.main import app
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_coverage_prints_a_table_and_writes_figures_and_an_image(tmp_path):
    figures, image = tmp_path / 'coverage.json', tmp_path / 'coverage.png'
    output = mctrack('coverage', 'pitch5', '--cell', 2, '--json', figures, '--image', image)
    assert 'share.at_least_1' in output
    content = json.loads(figures.read_text())
    assert content['command'] == 'mctrack coverage pitch5 --cell 2 --reach 200'
    assert content['figures']['area_m2'] == 7140.0
    assert cv2.imread(str(image)).shape[1] > 1500


def test_coverage_of_an_area_lists_its_blind_areas(tmp_path):
    figures = tmp_path / 'coverage.json'
    mctrack('coverage', 'pitch5', '--area=-120,0,105,68', '--cell', 2, '--json', figures)
    values = json.loads(figures.read_text())['figures']
    assert values['blind.count'] >= 1
    assert values['blind.1.x_m'] < 0
    assert values['blind.m2'] == pytest.approx(values['area_m2'] * values['share.exactly_0'])


def test_coverage_of_a_far_site_is_that_of_the_near_one(tmp_path):
    figures, output = [], ''
    for name, offset in (('near', (0.0, 0.0)), ('far', (389010.5, 5820020.25))):
        write_far_hall(tmp_path / name, offset, area='')
        options = ('--cell', 1, '--reach', 30, '--json', tmp_path / 'coverage.json')
        image = tmp_path / f'{name}.png'
        site = tmp_path / name / 'site.yaml'
        output = mctrack('coverage', site, *options, '--image', image)
        figures.append(json.loads((tmp_path / 'coverage.json').read_text())['figures'])
        assert cv2.imread(str(image)).shape[1] > 1000
    near, far = figures
    assert near['blind.count'] >= 1
    for axis, along in (('x', 389010.5), ('y', 5820020.25)):
        for number in range(1, min(near['blind.count'], 20) + 1):
            far[f'blind.{number}.{axis}_m'] -= along
    # where cells begin moves with the seen area's corner, by rounding
    assert far == pytest.approx(near, rel=0.01, abs=0.01)
    low = 5820020.25 - 22.0 - 30.0
    assert any(f'y {low + off:.0f}' in output for off in range(60))


def test_coverage_refuses_a_crossing_area():
    with pytest.raises(FieldOfViewError, match='the area crosses or touches itself near'):
        mctrack('coverage', 'pitch5', '--area', '0,0,9,9,9,0,0,5')


def test_images_without_the_page_to_draw_on_are_refused():
    with pytest.raises(ValueError, match='needs --web'):
        mctrack('coverage', 'pitch5', '--source', 'cam1=cam1.png')
