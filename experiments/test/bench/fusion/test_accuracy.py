import pytest

from mctrack_experiments.bench.fusion.accuracy import MEASURES, measure_accuracy, summary


def score(idf1, error=0.1):
    return dict.fromkeys(MEASURES, 0.0) | {'idf1': idf1, 'position_error_m': error}


def test_gains_are_paired_scene_by_scene():
    figures = summary(
        [
            {'fusion': score(0.9), 'norfair': score(0.8), 'true_association': score(1.0)},
            {'fusion': score(0.7), 'norfair': score(0.8), 'true_association': score(1.0)},
        ]
    )
    assert figures['idf1'] == pytest.approx(0.8)
    assert (figures['idf1_least'], figures['idf1_most']) == (0.7, 0.9)
    assert figures['over_norfair.idf1'] == pytest.approx(0.0)
    assert figures['over_norfair.idf1_least'] == pytest.approx(-0.1)


def test_position_error_is_held_against_the_true_association():
    figures = summary([{'fusion': score(1.0, 0.11), 'true_association': score(1.0, 0.1)}])
    assert figures['position_error_ratio'] == pytest.approx(1.1)


def test_scenes_of_both_kinds_are_scored_in_processes(folder):
    done = []
    figures = measure_accuracy(folder, (), (1,), 60, lambda *state: done.append(state))
    assert done == [(0, 2), (1, 2), (2, 2)]
    assert figures['base.mota'] > 0.9
    assert figures['crowd.mota'] > 0.7
