"""Zone events tick after tick."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtri

from mctrack_ros.interfaces import EventCode, Events, TrackStatus
from mctrack_ros.zones.engine import MEMORY_NS, ZoneEngine
from mctrack_ros.zones.shapes import Line, Zone, Zones
from zone_walks import corrections, happened, stamp_ns, tracks

SQUARE = ((0.0, -5.0), (10.0, -5.0), (10.0, 5.0), (0.0, 5.0))
ROOM = Zones((Zone('room', SQUARE),), (Line('door', ((0.0, -5.0), (0.0, 5.0))),))
"""A room right of a line that leads up; its left is outside."""
IN_AND_OUT = ('ENTER_ZONE', 'LEAVE_ZONE')
CROSSINGS = ('CROSS_LEFT', 'CROSS_RIGHT')
SIGMA = 0.1
BAND = SIGMA * float(ndtri(0.99))
"""So far from an edge a side is decided, m."""


class Site:
    """An engine, and all that it told."""

    def __init__(self, zones=ROOM):
        self.engine, self.tick, self.told, self.events = ZoneEngine(zones), 0, [], []

    def step(self, places, *pairs, **columns):
        """Pass a tick of tracks, id -> x or (x, y), and corrections; return what happened."""
        places = {k: v if isinstance(v, tuple) else (v, 0.0) for k, v in places.items()}
        rows, corrected = (
            tracks(self.tick, places, SIGMA, **columns),
            corrections(self.tick, *pairs),
        )
        events = self.engine.step(rows, corrected)
        self.tick += 1
        self.events.append(events)
        self.told += happened(events)
        return happened(events)

    def wait(self, seconds, places=None):
        for _ in range(round(seconds / 0.04)):
            self.step(places or {})

    def of(self, *names):
        return [each for each in self.told if each[0] in names]


def test_who_walks_in_and_out_is_told_with_his_place_and_how_sure_it_is():
    site = Site()
    for x in (-1.0, -0.2, 0.2, 0.3, 9.0, 10.1, 10.3):
        site.step({7: x})
    assert site.told == [
        ('ENTER_ZONE', 7, 1),
        ('CROSS_RIGHT', 7, 2),
        ('OCCUPANCY', 0, 1),
        ('LEAVE_ZONE', 7, 1),
        ('OCCUPANCY', 0, 1),
    ]
    entered = site.events[3]
    assert entered.stamp_ns == stamp_ns(3)
    assert entered.event.tolist() == sorted(entered.event.tolist())
    np.testing.assert_allclose(entered.position[0], [0.3, 0.0, 0.0], atol=1e-6)
    assert entered.probability[0] == pytest.approx(0.99865, abs=1e-5)
    occupancy = entered.select(entered.event == EventCode.OCCUPANCY)
    assert (occupancy.old_id.tolist(), occupancy.new_id.tolist()) == ([0], [1])


def test_who_begins_inside_enters_and_who_ends_inside_leaves_after_a_pause():
    site = Site()
    assert site.step({1: 5.0})[0] == ('ENTER_ZONE', 1, 1)
    site.wait(1.0)
    assert site.of('LEAVE_ZONE') == []
    site.step({})
    assert site.of('LEAVE_ZONE') == [('LEAVE_ZONE', 1, 1)]
    left = site.events[-1]
    assert left.probability[0] == 0.0
    np.testing.assert_allclose(left.position[0, :2], [5.0, 0.0])


def test_a_short_absence_is_no_absence():
    site = Site()
    site.step({1: 5.0})
    site.wait(0.96)
    site.step({1: 6.0})
    assert len(site.of(*IN_AND_OUT)) == 1


def test_who_is_away_for_longer_than_the_pause_between_two_ticks_stays():
    site = Site()
    site.step({1: 5.0})
    site.tick += 50
    site.step({1: 5.0})
    assert len(site.of(*IN_AND_OUT)) == 1


def test_only_tracks_that_the_tracker_stands_for_count():
    site = Site()
    for status in (TrackStatus.TENTATIVE, TrackStatus.DELETED):
        site.step({1: 5.0}, status=[status])
    site.step({2: (np.nan, 0.0)})
    assert site.told == []


def test_a_dwell_is_told_once_a_stay_and_a_crowd_when_it_exceeds_the_limit():
    site = Site(Zones((Zone('room', SQUARE, dwell_s=2.0, limit=2),)))
    site.wait(5.0, {1: 5.0})
    assert site.of('DWELL') == [('DWELL', 1, 1)]
    assert site.events[50].event.tolist() == [EventCode.DWELL]
    site.step({1: 5.0, 2: 5.0})
    assert site.of('CROWDED') == []
    site.step({1: 5.0, 2: 5.0, 3: 5.0})
    (row,) = np.flatnonzero(site.events[-1].event == EventCode.CROWDED)
    assert (site.events[-1].old_id[row], site.events[-1].new_id[row]) == (2, 3)
    site.step({1: 5.0, 2: 5.0, 3: 5.0, 4: 5.0})
    assert len(site.of('CROWDED')) == 1
    site.step({1: -5.0})
    site.step({1: 5.0})
    site.wait(3.0, {1: 5.0})
    assert len(site.of('DWELL')) == 2


def test_who_walks_around_the_end_of_a_line_does_not_cross_it():
    site = Site()
    for x, y in ((-2, 0), (-2, 8), (2, 8), (2, 0), (-2, 0)):
        site.step({1: (float(x), float(y))})
    assert site.of(*CROSSINGS) == [('CROSS_LEFT', 1, 2)]


def test_a_line_with_a_corner_is_crossed_where_it_is_passed():
    corner = Zones(lines=(Line('corner', ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0))),))
    site = Site(corner)
    for place in ((2.0, -2.0), (2.0, 2.0), (6.0, 2.0), (2.0, -2.0), (5.0, 5.0)):
        site.step({1: place})
    assert [name for name, *_ in site.told] == ['CROSS_LEFT', 'CROSS_RIGHT']


def test_a_new_name_changes_nothing_inside():
    site = Site()
    site.step({1: 5.0})
    site.step({2: 5.0}, (1, 2))
    site.wait(2.0, {2: 5.0})
    assert site.of(*IN_AND_OUT, 'OCCUPANCY') == [('ENTER_ZONE', 1, 1), ('OCCUPANCY', 0, 1)]
    site.step({2: -5.0})
    assert site.of('LEAVE_ZONE') == [('LEAVE_ZONE', 2, 1)]


def test_two_who_exchange_their_names_stay_where_they_are():
    site = Site()
    site.step({1: 5.0, 2: -5.0})
    site.step({2: 5.0, 1: -5.0}, (1, 2), (2, 1))
    site.wait(2.0, {2: 5.0, 1: -5.0})
    assert site.of(*IN_AND_OUT, *CROSSINGS) == [('ENTER_ZONE', 1, 1)]
    site.step({2: -5.0, 1: 5.0})
    assert site.of('LEAVE_ZONE')[-1:] == [('LEAVE_ZONE', 2, 1)]
    assert site.of('CROSS_RIGHT') == [('CROSS_RIGHT', 1, 2)]


def test_a_track_that_is_joined_to_another_inside_leaves_nobody():
    site = Site()
    site.step({1: 5.0, 2: 5.1})
    site.step({1: 5.0}, (2, 1))
    site.wait(2.0, {1: 5.0})
    assert site.of('LEAVE_ZONE') == []
    assert site.events[1].select(site.events[1].event == EventCode.OCCUPANCY).new_id.tolist() == [
        1
    ]


def test_who_ends_on_the_line_and_is_found_again_beyond_it_has_crossed_once():
    site = Site()
    for x in (-1.0, -0.5, -0.1, 0.1):
        site.step({1: x})
    site.wait(3.0)
    for x in (0.8, 1.0):
        site.step({5: x})
    assert site.of(*CROSSINGS) == []
    site.step({1: 1.2}, (5, 1))
    site.wait(2.0, {1: 1.2})
    assert site.of(*CROSSINGS) == [('CROSS_RIGHT', 1, 2)]


def test_who_is_renamed_on_the_line_has_crossed_once():
    site = Site()
    for x in (-1.0, -0.1):
        site.step({1: x})
    site.step({2: 0.0}, (1, 2))
    for x in (0.1, 1.0):
        site.step({2: x})
    assert site.of(*CROSSINGS) == [('CROSS_RIGHT', 2, 2)]


@pytest.mark.parametrize('born', [-1.0, 1.0])
def test_two_tracks_of_one_who_crosses_count_once_when_they_are_joined(born):
    """The second track counts if it crossed itself; if it began beyond, joining tells it."""
    site = Site()
    site.step({1: -1.0})
    site.step({1: -0.1, 2: born})
    site.step({1: 0.0, 2: 1.0})
    site.step({1: 1.0}, (2, 1))
    site.wait(2.0, {1: 1.0})
    assert [name for name, *_ in site.of(*CROSSINGS)] == ['CROSS_RIGHT']
    assert site.events[-1].zone.tolist() == []


def test_who_is_exchanged_with_one_who_is_lost_takes_nothing_over():
    """The lost one was left of the line at the time at which the other was right of it."""
    site = Site()
    site.step({1: -1.0, 2: 1.0})
    site.wait(0.5, {2: 1.0})
    site.step({1: 1.0}, (2, 1))
    site.wait(2.0, {1: 1.0})
    assert site.of(*CROSSINGS) == []


def test_when_time_begins_anew_nobody_is_inside():
    site = Site()
    site.step({1: 5.0})
    site.tick = -100
    site.step({9: -5.0})
    assert site.told[-2:] == [('LEAVE_ZONE', 1, 1), ('OCCUPANCY', 0, 1)]


def test_it_forgets_who_is_long_gone():
    site = Site()
    for track in range(1, 200):
        site.step({track: 5.0})
    site.tick += MEMORY_NS // 40_000_000 + 10
    site.step({})
    assert len(site.engine._lives) == 0


def test_without_zones_nothing_is_told():
    site = Site(Zones())
    assert site.step({1: 5.0}) == []


BIG = st.tuples(st.sampled_from([-1.0, 1.0]), st.floats(3 * BAND, 8 * BAND)).map(np.prod)
SMALL = st.floats(-BAND / 2, BAND / 2)
WALK = st.lists(BIG | SMALL, min_size=2, max_size=12)
"""Distances from an edge at which somebody turns: clearly off it, or on it."""


def paced(turns):
    """Return the distances of a walk from turn to turn, tick by tick, m."""
    steps = [np.linspace(a, b, 6)[:-1] for a, b in pairwise(turns)]
    return np.concatenate([*steps, turns[-1:]])


def sides_of(turns):
    """Return the sides on which somebody is clearly, one after the other."""
    sides = [np.sign(each) for each in turns if abs(each) > BAND]
    return [b for a, b in zip([0, *sides], sides) if a != b]


@settings(max_examples=150, deadline=None)
@given(walks=st.lists(WALK, min_size=1, max_size=4), data=st.data())
def test_noise_and_corrections_at_the_edge_change_no_count(walks, data):
    """Random walks across the edge, with noise, whose ids change and are exchanged at random."""
    noise = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    paths = [paced(turns) for turns in walks]
    length = max(map(len, paths))
    names, fresh, site = list(range(1, len(walks) + 1)), len(walks) + 1, Site()
    for tick in range(length):
        pairs = []
        if data.draw(st.integers(0, 9)) == 0:
            before = list(names)
            names = data.draw(st.permutations(names))
            if data.draw(st.booleans()):
                names[0], fresh = fresh, fresh + 1
            pairs = [pair for pair in zip(before, names) if pair[0] != pair[1]]
        shift = noise.uniform(-BAND / 2, BAND / 2, len(walks)) * 0.999
        x = [path[min(tick, len(path) - 1)] for path in paths]
        site.step(dict(zip(names, np.add(x, shift).tolist())), *pairs)
    stays = [sides_of(turns) for turns in walks]
    changes = [pair for sides in stays for pair in pairwise(sides)]
    assert len(site.of('CROSS_RIGHT')) == sum(pair == (-1, 1) for pair in changes)
    assert len(site.of('CROSS_LEFT')) == sum(pair == (1, -1) for pair in changes)
    assert len(site.of('ENTER_ZONE')) == sum(sides.count(1) for sides in stays)
    ended = sum(sides[-1:] == [1] for sides in stays)
    assert len(site.of('ENTER_ZONE')) - len(site.of('LEAVE_ZONE')) == ended
    counts = [each for events in site.events for each in occupancies(events)]
    assert (counts[-1][1] if counts else 0) == ended
    for (_, before), (after, _) in pairwise(counts):
        assert before == after


def occupancies(events: Events):
    rows = events.select(events.event == EventCode.OCCUPANCY)
    return list(zip(rows.old_id.tolist(), rows.new_id.tolist()))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_decided_side_is_the_true_one_while_noise_is_within_the_band(seed):
    """Of any walk: the count is never above that without noise, and its parity is right."""
    random = np.random.default_rng(seed)
    truth = np.cumsum(random.normal(0, BAND / 2, 200)) + BAND
    noisy = truth + random.uniform(-BAND, BAND, 200) * 0.999
    site = Site()
    for x in noisy.tolist():
        site.step({1: x})
    crossed = site.of(*CROSSINGS)
    true_ways = np.diff(np.sign(truth[truth != 0]))
    assert len(crossed) <= np.count_nonzero(true_ways)
    assert all(one != other for one, other in pairwise(crossed))
    sure = np.flatnonzero(np.abs(noisy) > BAND)
    if len(sure):
        ends = np.sign(truth[sure[[0, -1]]])
        assert len(crossed) % 2 == int(ends[0] != ends[1])


def test_an_engine_that_remembers_what_another_knew_tells_what_that_one_would():
    site = Site()
    for x in (-1.0, -0.2, 0.2, 3.0):
        site.step({7: x, 8: -x})
    memory = json.loads(json.dumps(site.engine.memory()))
    later, other = Site(), Site(Zones((Zone('yard', SQUARE),)))
    for each in (later, other):
        each.engine.remember(memory)
        each.tick = site.tick
    for x in (4.0, 1.0, -1.0, -2.0):
        assert site.step({7: x, 8: -x}) == later.step({7: x, 8: -x})
        other.step({7: x, 8: -x})
    assert ('LEAVE_ZONE', 7, 1) in later.told
    assert ('ENTER_ZONE', 7, 1) not in later.told
    assert ('ENTER_ZONE', 7, 1) in other.told
