from dataclasses import replace

import numpy as np
import pytest

from mctrack_experiments.papers.event_tracking.happenings import (
    EventScore,
    Happening,
    People,
    score_events,
    told_happenings,
    true_happenings,
)
from mctrack_ros.interfaces import Detections, EventCode, Events

SECOND = 10**9


def merge(seconds, *targets):
    return Happening(round(seconds * SECOND), EventCode.MERGE, frozenset(targets))


def test_the_same_targets_in_time_are_a_hit():
    true, told = [merge(1, 3, 4), merge(5, 3, 4)], [merge(1.5, 3, 4), merge(5.6, 3, 4)]
    assert score_events(true, told, 0.5, 1.0) == EventScore(2, 2, 1, 2.0)


def test_a_group_told_in_part_is_a_hit_of_the_majority_only():
    true, told = [merge(1, 3, 4, 5)], [merge(1, 3, 4)]
    assert score_events(true, told, 0.5, 1.0).hits == 0
    assert score_events(true, told, 0.5, 0.5).hits == 1


def test_each_event_is_used_once_and_as_many_as_possible():
    true = [merge(1.0, 3, 4), merge(1.4, 3, 4)]
    told = [merge(1.2, 3, 4), merge(0.6, 3, 4)]
    assert score_events(true, told, 0.5, 1.0) == EventScore(2, 2, 2, 2.0)


def test_ratio_is_flattered_by_false_events_and_f1_is_not():
    score = EventScore(true=10, told=10, hits=5)
    assert (score.ratio, score.precision, score.recall, score.f1) == (1.0, 0.5, 0.5, 0.5)


def test_probabilities_promise_hits_and_the_doubted_are_counted_apart():
    true = [merge(1, 3, 4), merge(5, 3, 4), merge(9, 3, 4)]
    told = [
        replace(merge(when, 3, 4), probability=probability)
        for when, probability in ((1, 0.9), (3, 0.9), (5, 0.5), (7, 0.7))
    ]
    score = score_events(true, told, 0.5, 1.0) + score_events(true, [], 0.5, 1.0)
    assert (score.true, score.told, score.hits) == (6, 4, 2)
    assert score.promised == pytest.approx(0.75)
    assert (score.doubted, score.doubted_precision) == (2, 0.5)


@pytest.mark.parametrize('name', ['ratio', 'recall', 'f1'])
def test_without_events_there_is_no_score(name):
    assert np.isnan(getattr(EventScore(), name))


def seen(stamp_ns, *rows, field):
    ids, places = zip(*rows)
    position = [[x, 0.0, 0.0] for x in places]
    return Detections.build(stamp_ns, position=position, **{field: ids})


def test_a_local_track_is_whom_it_was_nearest_to_around_that_time():
    stamps = [step * SECOND // 25 for step in range(100)]
    truth = [seen(stamp, (7, 0.0), (8, 5.0), field='track_id') for stamp in stamps]
    place = [0.3 if step < 50 else 4.8 for step in range(100)]
    found = [seen(stamp, (1, x), field='local_id') for stamp, x in zip(stamps, place)]
    people = People(truth, found, 1.5, 0.5)
    assert people.at(1, stamps[10]) == 7
    assert people.at(1, stamps[90]) == 8
    assert people.at(1, 60 * SECOND) == 8
    assert people.at(2, stamps[10]) < 0


def test_events_name_everybody_concerned():
    others = np.zeros((1, 16), np.uint32)
    others[0, :2] = 8, 9
    rows = Events.build(SECOND, event=[EventCode.SPLIT], track_id=[7], others=others)
    assert true_happenings([rows])[0].targets == {7, 8, 9}
    nobody = People([], [], 1.0, 1.0)
    rows = Events.build(SECOND, event=[EventCode.SPLIT], local_id=[1], others=others)
    assert told_happenings([rows], nobody, nobody)[0].targets == {-1, -8, -9}


def test_an_event_without_a_local_track_is_of_the_global_one():
    truth = [seen(SECOND, (7, 0.0), field='track_id')]
    found = [seen(SECOND, (40, 0.2), field='track_id')]
    rows = Events.build(SECOND, event=[EventCode.EXIT], track_id=[40])
    everybody = People(truth, found, 1.5, 1.0, 'track_id')
    told = told_happenings([rows], People([], [], 1.0, 1.0), everybody)
    assert told == [Happening(SECOND, EventCode.EXIT, frozenset({7}))]


def test_a_member_is_whom_its_global_track_stands_for_or_else_its_local_one():
    truth = [seen(SECOND, (7, 0.0), (8, 9.0), field='track_id')]
    found = [seen(SECOND, (40, 0.2), (41, 9.0), field='track_id')]
    local = [seen(SECOND, (3, 0.1), (1, 9.0), field='local_id')]
    others = np.zeros((2, 1, 16), np.uint32)
    others[0, 0, 0], others[1, 0, 1] = 3, 41
    rows = Events.build(
        SECOND,
        event=[EventCode.MERGE],
        local_id=[5],
        others=others[0],
        other_tracks=others[1],
    )
    everybody = People(truth, found, 1.5, 1.0, 'track_id')
    told = told_happenings([rows], People(truth, local, 1.5, 1.0), everybody)
    assert told[0].targets == {-5, 7, 8}
