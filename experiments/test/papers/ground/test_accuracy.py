import pytest

from mctrack_experiments.papers.ground.accuracy import SPACINGS_M, measure
from mctrack_experiments.papers.ground.honesty import EDGES, honesty, honesty_of_methods


@pytest.fixture(scope='module')
def clicked():
    return {spacing: measure(spacing, -0.2, 0.5, 2) for spacing in SPACINGS_M}


def test_the_fitted_camera_is_centimetres_off_where_the_paper_s_grid_is_decimetres(clicked):
    assert clicked[8]['fitted.rmse_max_m'] < 0.06
    assert clicked[8]['iterated.rmse_max_m'] > 0.1
    assert clicked[8]['plane1.rmse_max_m'] > 1.0


def test_the_error_of_equal_ratios_grows_with_the_cell_and_that_of_the_stop_does_not(clicked):
    by_ratio = [clicked[spacing]['iterated.by_ratio_max_m'] for spacing in SPACINGS_M]
    by_stop = [clicked[spacing]['iterated.by_stop_max_m'] for spacing in SPACINGS_M]
    assert by_ratio == sorted(by_ratio)
    assert max(by_stop) < 0.3


def test_four_points_are_refused_by_the_fitted_camera_alone(clicked):
    assert clicked[40]['points'] == 4
    assert clicked[40]['fitted.refused'] == 1
    assert clicked[40]['cell.rmse_max_m'] < 1.0


def test_a_straight_lens_and_exact_points_leave_no_error_but_that_of_equal_ratios():
    exact = measure(16, 0.0, 0.0, 1)
    assert exact['fitted.rmse_max_m'] < 1e-4
    assert exact['cell.rmse_max_m'] < 1e-6
    assert exact['homography.rmse_max_m'] < 1e-5
    assert exact['iterated.rmse_max_m'] > 0.1


def test_predicted_errors_are_those_that_occur_with_real_lenses():
    found = honesty(60)
    assert found['nees.low'] <= found['nees.mean'] <= found['nees.high']
    assert found['nees.coverage'] > 0.92


@pytest.mark.parametrize('name', ['middle', 'principal_20_15', 'k2_below', 'all'])
def test_predicted_errors_are_those_that_occur_at_the_edges_of_real_lenses(name):
    found = honesty(30, EDGES[name])
    assert 1.4 < found['nees.mean'] <= found['nees.high']
    assert found['nees.coverage'] > 0.9


def test_a_real_lens_leaves_the_fitted_camera_centimetres_off():
    found = measure(8, -0.2, 0.5, 3, is_drawn=True)
    assert found['fitted.rmse_max_m'] < 0.06
    assert found['fitted.crb_ratio_max'] < 1.5


def test_every_method_s_predicted_errors_are_those_that_occur_inside_and_not_smaller_outside():
    found = honesty_of_methods(6)
    for method in ('fitted', 'cell', 'iterated', 'homography'):
        assert 1.4 < found[f'{method}.nees.inside'] < 2.6
        assert 0.5 < found[f'{method}.nees.outside'] < 4.0
