from mctrack_experiments.papers.event_tracking.beginning import (
    Beginning,
    beginning_figures,
    delays,
)
from mctrack_experiments.papers.event_tracking.happenings import EventScore, Happening
from mctrack_ros.interfaces import EventCode


def new(seconds, *targets):
    return Happening(round(seconds * 1e9), EventCode.NEW, frozenset(targets))


def test_delay_is_until_the_same_person_is_first_told_of():
    true = [new(0.0, 1), new(0.0, 2), new(1.0, 3)]
    told = [new(0.4, 2), new(1.5, 1), new(2.0, 1), new(0.5, 3)]
    assert delays(true, told) == [1.5, 0.4, float('inf')]


def test_who_is_told_late_counts_within_the_longer_window_alone():
    late = Beginning((EventScore(2, 2, 0), EventScore(2, 2, 2)), (1.0, 1.5), 0.8)
    soon = Beginning((EventScore(2, 2, 2), EventScore(2, 2, 2)), (0.2, 0.2), 1.0)
    figures = beginning_figures('start', [late, soon])
    assert figures['start.e1.within_500ms.f1'] == 0.5
    assert figures['start.e1.within_2000ms.f1'] == 1.0
    assert figures['start.e1.delay_median_s'] == 0.6
    assert figures['start.mota'] == 0.9
