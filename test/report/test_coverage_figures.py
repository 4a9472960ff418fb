"""Coverage as figures and as an image."""

import math

import pytest
import shapely

from mctrack_ros.ground.coverage.coverage import CoverageConfig, coverage_of
from mctrack_ros.ground.coverage.view import View
from mctrack_ros.report.coverage_figures import coverage_figures
from mctrack_ros.report.coverage_image import draw_coverage

AREA = shapely.box(0, 0, 20, 10)


@pytest.fixture
def coverage():
    fields = {
        'door': shapely.box(2, 0, 8, 10),
        'hall': shapely.box(6, 0, 12, 10),
        'stage': shapely.box(12.5, 0, 20, 10),
        'sky': shapely.Polygon(),
    }
    views = {name: View(field) for name, field in fields.items()}
    return coverage_of(views, AREA, CoverageConfig(cell=0.5))


def test_figures_name_shares_blind_areas_and_hand_overs(coverage):
    figures = coverage_figures(coverage, 'hall', 'mctrack coverage hall.yaml').figures
    expected = {
        'area_m2': 200, 'union_m2': 175, 'share.at_least_1': 0.875, 'share.at_least_2': 0.1,
        'share.at_least_3': 0, 'share.exactly_0': 0.125, 'share.exactly_1': 0.775,
        'share.exactly_2': 0.1, 'blind.count': 2, 'blind.m2': 25, 'blind.1.m2': 20,
        'blind.1.x_m': 1, 'blind.1.y_m': 5, 'blind.2.m2': 5, 'camera.door.share': 0.3,
        'camera.sky.field_m2': 0, 'hand_over.door-hall.m2': 20, 'hand_over.hall-stage.gap_m': 0.5,
    }  # fmt: skip
    assert {name: figures[name] for name in expected} == pytest.approx(expected)
    assert 'hand_over.door-stage.m2' not in figures
    assert math.isnan(figures['error.fused.median_m'])


def test_image_is_drawn_without_calibrations_and_with_a_blind_camera(coverage, tmp_path):
    draw_coverage(coverage, 'hall', tmp_path / 'new' / 'coverage.svg')
    text = (tmp_path / 'new' / 'coverage.svg').read_text()
    assert '<svg' in text
