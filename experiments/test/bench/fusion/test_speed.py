import pytest

from mctrack_experiments.bench.fusion.speed import SpeedRun, chosen_runs, figures_of, measured

NORFAIR, SLOW = 'norfair', 'stonesoup-gnn'


def test_ratios_are_of_medians_to_ours_after_the_warm_up():
    figures = figures_of('s', {'fusion': [9.0] * 25 + [1.0] * 50, 'stonesoup-gnn': [150.0] * 75})
    assert figures['s.p50_ms'] == 1.0
    assert figures['s.stonesoup_gnn_p50_ms'] == 150.0
    assert figures['s.stonesoup_gnn_ratio'] == 150.0


def test_growth_is_ours_over_that_of_the_smaller_scene():
    figures = figures_of('s', {'fusion': [6.0] * 40, 'smaller': [2.0] * 40})
    assert figures['s.growth'] == 3.0
    assert 's.smaller_ratio' not in figures


@pytest.mark.parametrize(('quick', 'slow'), [(False, True), (True, False)])
def test_slow_trackers_are_left_out_of_a_quick_run(quick, slow):
    beside = {peer for run in chosen_runs((NORFAIR, SLOW), quick) for peer in run.peers}
    assert beside == ({NORFAIR, SLOW} if slow else {NORFAIR})


def test_no_scene_is_run_twice_without_peers():
    names = [run.name for run in chosen_runs((), quick=False)]
    assert len(set(names)) == len(names) == 5


def test_a_run_gives_wall_and_processor_times_of_all_that_take_turns(folder):
    figures = measured((folder, SpeedRun('small', {'targets': 5}, 30, (), {'targets': 2})))
    assert figures['small.p50_ms'] > 0
    assert figures['small.cpu.p50_ms'] > 0
    assert figures['small.cpu.smaller_p50_ms'] > 0
