import pytest

from mctrack_experiments.papers.covering.experiment import assignment, averaged, continuity, scored
from mctrack_experiments.papers.covering.trackers import NAMES, PROPOSED

CAMERAS = ('one', 'two')
PARTS = ('greedy', 'association', 'fusion')


def test_the_table_has_a_row_for_every_tracker(walkers):
    figures = scored('hall', walkers, CAMERAS)
    assert {name.rsplit('.', 1)[0] for name in figures} == {f'hall.{name}' for name in NAMES}
    assert figures['hall.covering_text.mota'] > 0.95


def test_without_truth_it_is_told_how_steady_tracks_are(walkers):
    figures = continuity('hall', walkers, CAMERAS)
    assert figures['hall.jpda.ids'] == 3
    assert figures['hall.jpda.isolated_breaks'] == 0


def test_who_walks_apart_is_assigned_as_well_greedily(walkers):
    figures = assignment('hall', walkers, CAMERAS)
    for name in PROPOSED:
        label = f'assignment.hall.{name}'
        assert figures[f'{label}.cost_ratio'] == 1.0
        shares = [figures[f'{label}.{part}_share_of_tick'] for part in PARTS]
        assert 0 < shares[0] < shares[1] < shares[2] < 1  # each holds the one before
    assert figures['assignment.hall.optimal.mota'] > 0.95


def test_switches_are_added_up_and_scores_averaged():
    figures = averaged([{'a.mota': 0.5, 'a.switches': 2}, {'a.mota': 0.7, 'a.switches': 1}])
    assert figures == {'a.mota': pytest.approx(0.6), 'a.switches': 3}
