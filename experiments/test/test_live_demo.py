from mctrack_experiments.live_demo import median_run
from mctrack_ros.evaluation.figures import Figures


def run(mota, late_ticks, ticks):
    figures = {'mota': mota, 'late_ticks': late_ticks, 'ticks': ticks}
    return Figures('demo', 'mctrack demo', {'seed': 7, 'gate_m': 1.0}, figures)


def test_published_run_is_the_median_and_says_how_far_runs_lie_apart():
    runs = [run(0.9, 0, 10), run(0.5, 7, 11), run(0.8, 2, 12)]
    figures = median_run(runs, (1001, 1002, 1003))
    assert figures.figures == {
        **{'mota': 0.8, 'mota.least': 0.5, 'mota.most': 0.9},
        **{'late_ticks': 2, 'late_ticks.least': 0, 'late_ticks.most': 7},
        'ticks': 11,
    }
    assert 'seed' not in figures.protocol
    assert figures.protocol['seeds'] == '1001, 1002, 1003'
