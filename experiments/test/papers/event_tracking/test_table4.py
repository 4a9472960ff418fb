import pytest

from mctrack_experiments.papers.event_tracking.table4 import reproduce_table4


@pytest.mark.xdist_group('match')
def test_a_short_match_is_scored_event_by_event(kept_matches):
    figures = reproduce_table4(seeds=(1,), duration_s=3.0).figures
    for code in ('e1', 'e3', 'e5'):
        assert figures[f'{code}.true'] > 0
        assert figures[f'{code}.f1'] > 0.5
        assert figures[f'{code}.majority.f1'] >= figures[f'{code}.f1']
    assert figures['given.e1.within_500ms.f1'] > 0.5
    assert figures['first_pass.e1.within_500ms.f1'] > 0.5
    assert figures['learned.e1.within_500ms.f1'] == 0  # nobody is seen while it is learned
    assert figures['learned.e1.within_2000ms.f1'] > 0.5
    assert figures['given.e1.delay_median_s'] < 0.5
    assert figures['given.mota'] > 0.8
    assert figures['correlation'] > 0.9
    assert figures['one_id_share'] > 0.5
    assert figures['mota'] > 0.8
    assert 0 <= figures['switches_isolated'] <= figures['switches_a_minute']
    assert figures['kits.purity'] > 0.95
    assert figures['kits.found'] >= 2
