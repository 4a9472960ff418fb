"""Fusion of cells: who keeps an id, whatever the cells do."""

import itertools

import numpy as np
import pytest

from mctrack_ros.config import config_from
from mctrack_ros.fusion import FUSION, open_batcher, open_fusion
from mctrack_ros.fusion.cells.report import CellReport, unusable_count
from mctrack_ros.interfaces import (
    CameraRows,
    EventCode,
    Feedback,
    RowsTick,
    Tracks,
    TrackStatus,
)

PERIOD_S = 0.1
RED, BLUE = np.zeros((2, 48))
RED[:4], BLUE[30:34] = 0.25, 0.25
WAY = (1.4, 0.0)


def config(**values):
    return config_from(FUSION, {'tracker': 'cells', 'batching': {'period': PERIOD_S}} | values)


def report(stamp_ns, people, renamed=None, status=TrackStatus.CONFIRMED):
    """Return what a cell says of people: id -> (place, velocity[, colours])."""
    names, rows = list(people), list(people.values())
    columns = {
        'position': [(*row[0], 0.0) for row in rows],
        'velocity': [row[1] for row in rows],
        'covariance': np.tile(np.diag([0.02, 0.02, 0.1, 0.1]), (len(rows), 1, 1)),
        'track_id': names,
    }
    if not names:
        columns = {}
    tracks = Tracks.build(
        stamp_ns,
        **columns,
        **({'status': [status] * len(names)} if names else {}),
    )
    told = {}
    if names:
        told = {
            'template': [row[2] if len(row) > 2 else np.zeros(48) for row in rows],
            'previous_id': [(renamed or {}).get(name, 0) for name in names],
        }
    return CellReport(tracks, Feedback.build(stamp_ns, **columns, **told))


class Site:
    """Cells that say what they are told to say, and their fusion."""

    def __init__(self, cells=('a', 'b'), first_id=1, **values):
        self.tracker = open_fusion(config(**values), cells, first_id)
        self.tick = 0
        self.events, self.deleted, self.tracks = [], [], None

    @property
    def now_s(self):
        return self.tick * PERIOD_S

    def step(self, **reports):
        """Let cells report: a mapping of people, or (people, what else `report` takes)."""
        self.tick += 1
        stamp_ns = round(self.now_s * 1e9)
        messages = [
            CameraRows(cell, report(stamp_ns, *(told if isinstance(told, tuple) else (told,))))
            for cell, told in reports.items()
        ]
        output = self.tracker.step(RowsTick.of(messages))
        self.tracks = output.tracks
        rows = output.events
        self.events += list(zip(rows.event, rows.old_id, rows.track_id))
        gone = output.tracks.status == TrackStatus.DELETED
        self.deleted += output.tracks.track_id[gone].tolist()
        shown = output.tracks.select(~gone)
        return dict(zip(shown.track_id.tolist(), shown.position[:, :2].astype(float).tolist()))

    def count(self, code):
        return sum(each[0] == code for each in self.events)


def walker(start, velocity=WAY):
    return lambda now_s: (np.add(start, np.multiply(velocity, now_s)).tolist(), velocity)


def test_an_id_goes_on_from_cell_to_cell_where_they_overlap():
    site, person = Site(), walker((-5.0, 0.0))
    ids, seeing = set(), []
    for _ in range(80):
        place, velocity = person(site.now_s + PERIOD_S)
        a = {7: (place, velocity)} if place[0] < 1.5 else {}
        b = {3: (place, velocity)} if place[0] > -1.5 else {}
        told = site.step(a=a, b=b)
        ids |= set(told)
        seeing.append(int(site.tracks.cameras[0]))
        assert np.allclose(told[1], place, atol=0.01)
    assert ids == {1}
    assert [each for each, _ in itertools.groupby(seeing)] == [1, 3, 2]
    assert site.events == [(EventCode.NEW, 0, 1)]


@pytest.mark.parametrize('gap_m', [2.0, 4.0])
def test_an_id_goes_on_across_a_strip_that_nobody_sees(gap_m):
    site, person = Site(), walker((-5.0, 0.0))
    for _ in range(90):
        place, velocity = person(site.now_s + PERIOD_S)
        a = {7: (place, velocity)} if place[0] < -gap_m / 2 else {}
        b = {3: (place, velocity)} if place[0] > gap_m / 2 else {}
        told = site.step(a=a, b=b)
    assert list(told) == [1]
    assert site.count(EventCode.NEW) == 1


def test_who_comes_out_where_the_lost_one_cannot_be_is_somebody_new():
    site, person = Site(), walker((-5.0, 0.0))
    for _ in range(40):
        site.step(a={7: person(site.now_s + PERIOD_S)}, b={})
    for _ in range(10):
        told = site.step(a={}, b={3: ((0.0, 25.0), (0.0, 1.0))})
    assert 2 in told
    assert site.count(EventCode.NEW) == 2


def test_a_cell_that_is_restarted_calls_its_people_otherwise_and_they_keep_their_ids():
    site = Site()
    people = [walker((4.0 * k, 3.0 * k), (1.0, 0.2 * k)) for k in range(4)]
    other = {50: ((60.0, 60.0), (0.0, 0.0))}
    for _ in range(20):
        now_s = site.now_s + PERIOD_S
        before = site.step(a={1 + k: one(now_s) for k, one in enumerate(people)}, b=other)
    for _ in range(25):
        site.step(b=other)
    for _ in range(15):
        now_s = site.now_s + PERIOD_S
        after = site.step(a={1001 + k: one(now_s) for k, one in enumerate(people)}, b=other)
    assert set(after) == set(before) == {1, 2, 3, 4, 5}
    for name, one in zip((1, 2, 3, 4), people):
        assert np.allclose(after[name], one(site.now_s)[0], atol=0.1)


def test_the_people_of_a_cell_that_dies_fade_and_the_others_go_on():
    site = Site(lost_time=3.0)
    for _ in range(10):
        site.step(a={1: ((0.0, 0.0), (0.0, 0.0))}, b={1: ((30.0, 0.0), (0.0, 0.0))})
    told = [site.step(b={1: ((30.0, 0.0), (0.0, 0.0))}) for _ in range(60)]
    assert set(told[5]) == {1, 2}
    assert all(set(each) == {2} for each in told[25:])
    assert site.deleted == [1]
    assert site.count(EventCode.EXIT) == 1


@pytest.mark.parametrize('bias_m', [0.4, 0.8])
def test_two_cells_that_disagree_by_a_bias_see_one(bias_m):
    site, person = Site(), walker((-6.0, 0.0))
    for _ in range(100):
        place, velocity = person(site.now_s + PERIOD_S)
        biased = (np.add(place, (0.0, bias_m)).tolist(), velocity)
        told = site.step(a={7: (place, velocity)}, b={3: biased} if place[0] > -3 else {})
        assert set(told) == {1}
    assert site.tracks.cameras.tolist() == [3]
    assert 0 < told[1][1] < bias_m
    assert site.tracks.covariance[0, 1, 1] > 0.04


def test_two_who_are_close_and_seen_by_different_cells_are_told_apart_by_colours():
    site = Site()
    one, other = walker((-5.0, 0.0)), walker((-5.0, 0.7))
    for _ in range(60):
        now_s = site.now_s + PERIOD_S
        told = site.step(a={1: (*one(now_s), RED)}, b={1: (*other(now_s), BLUE)})
    assert set(told) == {1, 2}
    for _ in range(20):
        now_s = site.now_s + PERIOD_S
        both = {1: (*one(now_s), RED), 2: (*other(now_s), BLUE)}
        told = site.step(a=both, b={1: both[2], 9: both[1]})
    assert set(told) == {1, 2}
    assert site.tracks.cameras.tolist() == [3, 3]
    assert told[1][1] < told[2][1]


def test_two_who_were_taken_for_one_part_and_the_first_keeps_the_id():
    site = Site()
    for _ in range(20):
        now_s = site.now_s + PERIOD_S
        told = site.step(a={1: walker((0.0, 0.0))(now_s)}, b={})
    for _ in range(20):
        now_s = site.now_s + PERIOD_S
        told = site.step(a={1: walker((0.0, 0.0))(now_s)}, b={4: walker((0.0, 0.6))(now_s)})
    assert set(told) == {1}
    began_s, start = site.now_s, walker((0.0, 0.6))(site.now_s)[0]
    for _ in range(40):
        now_s = site.now_s + PERIOD_S
        leaves = walker(start, (1.4, 1.0))(now_s - began_s)
        told = site.step(a={1: walker((0.0, 0.0))(now_s)}, b={4: leaves})
    assert set(told) == {1, 2}
    assert np.allclose(told[1], walker((0.0, 0.0))(site.now_s)[0], atol=0.05)
    assert np.allclose(told[2], leaves[0], atol=0.05)


def test_a_swap_in_one_cell_changes_nothing_where_another_sees_both():
    site = Site()
    one, other = walker((0.0, 0.0)), walker((0.0, 4.0))
    for _ in range(60):
        now_s = site.now_s + PERIOD_S
        swapped = site.tick > 25
        a = {1: other(now_s), 2: one(now_s)} if swapped else {1: one(now_s), 2: other(now_s)}
        told = site.step(a=a, b={1: one(now_s), 2: other(now_s)})
    assert set(told) == {1, 2}
    assert np.allclose(told[1], one(site.now_s)[0], atol=0.05)
    assert site.count(EventCode.NEW) == 2


def test_a_cells_own_correction_is_followed_where_no_other_sees_them():
    site = Site()
    one, other = walker((0.0, 0.0)), walker((0.0, 1.0))
    for _ in range(10):
        now_s = site.now_s + PERIOD_S
        site.step(a={1: one(now_s), 2: other(now_s)}, b={})
    now_s = site.now_s + PERIOD_S
    told = site.step(a=({1: other(now_s), 2: one(now_s)}, {1: 2, 2: 1}), b={})
    assert np.allclose(told[1], other(now_s)[0], atol=0.05)
    assert np.allclose(told[2], one(now_s)[0], atol=0.05)
    assert {(1, 2), (2, 1)} == {
        each[1:] for each in site.events if each[0] == EventCode.CORRECTION
    }
    assert site.deleted == []


def test_one_whom_his_cell_recognises_gets_his_id_back_and_so_does_he_in_other_cells():
    site = Site(cell_sigma=0.1)
    for _ in range(10):
        site.step(a={1: ((0.0, 0.0), (0.0, 0.0))}, b={})
    for _ in range(50):
        site.step(a={}, b={})
    back = ((9.0, 9.0), (0.0, 0.0))
    for _ in range(10):
        told = site.step(a={5: back}, b={8: back})
    assert set(told) == {2}
    told = site.step(a=({1: back}, {1: 5}), b={8: back})
    assert set(told) == {1}
    assert site.tracks.cameras[site.tracks.track_id == 1].tolist() == [3]
    for _ in range(10):
        assert set(site.step(a={1: back}, b={8: back})) == {1}
    assert site.deleted == [2]
    assert (EventCode.CORRECTION, 2, 1) in site.events


def test_cells_of_other_rates_and_latencies_lose_nothing():
    names, person = ('a', 'b', 'c'), walker((-10.0, 0.0))
    batcher = open_batcher(config(), names)
    tracker = open_fusion(config(), names)
    sent = []
    for name, period_s, late_s, sees in (
        ('a', 0.04, 0.01, (-20, -4)),
        ('b', 0.1, 0.35, (-6, 2)),
        ('c', 0.08, 0.15, (0, 20)),
    ):
        for number in range(round(14 / period_s)):
            stamp_s = 1 + number * period_s
            place, velocity = person(stamp_s)
            people = {4: (place, velocity)} if sees[0] < place[0] < sees[1] else {}
            rows = report(round(stamp_s * 1e9), people)
            sent.append((round((stamp_s + late_s) * 1e9), name, rows))
    ticks = []
    for arrival_ns, name, rows in sorted(sent, key=lambda each: each[:2]):
        ticks += batcher.add(name, rows, arrival_ns, arrival_ns)
    outputs = [tracker.step(tick) for tick in ticks + batcher.flush()]
    assert sum(int(tick.record.late.sum()) for tick in ticks) == 0
    assert not any(tick.record.added_ms.any() for tick in ticks)
    assert {name for each in outputs for name in each.tracks.track_id.tolist()} == {1}
    for each in outputs:
        place = person(each.tracks.stamp_ns * 1e-9)[0]
        assert np.allclose(each.tracks.position[0, :2], place, atol=0.01)


def test_what_is_no_state_is_dropped_counted_and_hurts_nobody():
    good = ((0.0, 0.0), (0.0, 0.0))
    rows = report(1, {1: good, 2: ((np.nan, 0.0), (0.0, 0.0)), 3: good, 4: good, 0: good})
    covariance = rows.tracks.covariance.copy()
    covariance[2] = np.diag([1.0, -1.0, 1.0, 1.0])
    covariance[3] = np.inf
    broken = CellReport(rows.tracks.replace(covariance=covariance), rows.feedback)
    assert unusable_count(broken) == 4
    output = open_fusion(config(), ('a',)).step(RowsTick.of([CameraRows('a', broken)]))
    assert output.tracks.track_id.tolist() == [1]
    assert np.isfinite(output.tracks.covariance).all()


def test_tentative_and_ended_tracks_of_a_cell_are_nobody():
    site = Site(cells=('a',))
    person = {1: ((0.0, 0.0), (0.0, 0.0))}
    assert site.step(a=(person, None, TrackStatus.TENTATIVE)) == {}
    assert site.step(a=(person, None, TrackStatus.DELETED)) == {}
    assert set(site.step(a=person)) == {1}
    assert set(site.step(a=(person, None, TrackStatus.COASTING))) == {1}
    assert site.tracks.status.tolist() == [TrackStatus.COASTING]


def test_ids_ascend_from_the_first_one_and_go_on_when_time_begins_anew():
    site = Site(cells=('a',), first_id=70)
    assert set(site.step(a={1: ((0.0, 0.0), (0.0, 0.0))})) == {70}
    site.tick = 500
    site.step(a={2: ((40.0, 0.0), (0.0, 0.0))})
    site.tick = 10
    told = site.step(a={3: ((0.0, 0.0), (0.0, 0.0))})
    assert set(told) == {72}
    assert set(site.deleted) == {70, 71}
    assert site.tracker.next_id == 73


def test_a_site_can_be_a_cell_of_a_larger_one():
    site = Site()
    for _ in range(5):
        site.step(a={1: ((0.0, 0.0), (0.0, 0.0), RED)}, b={1: ((30.0, 0.0), (0.0, 0.0), BLUE)})
    whole = CellReport(site.tracks, site.tracker.feedback())
    output = open_fusion(config(), ('site',)).step(RowsTick.of([CameraRows('site', whole)]))
    assert len(output.tracks) == 2
    assert np.allclose(site.tracker.feedback().template, [RED, BLUE])


def test_wrong_cells_and_wrong_times_are_refused():
    site = Site()
    with pytest.raises(ValueError, match="cell is 'c', expected one of"):
        site.step(c={})
    with pytest.raises(ValueError, match='distinct'):
        open_fusion(config(), ('a', 'a'))
    site.step(a={})
    site.tick -= 3
    with pytest.raises(ValueError, match='expected at least'):
        site.step(a={})
    with pytest.raises(OverflowError, match='ids have run out'):
        Site(first_id=2**32 - 1).step(a={1: ((0.0, 0.0), (0.0, 0.0))})
