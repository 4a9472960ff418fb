import numpy as np
import pytest

from mctrack_ros.fusion.lifecycle import DuplicateWatch
from mctrack_ros.fusion.table import TrackTable

TICK_S = 0.04
DISTANCE_M, ENOUGH_S = 1.0, 1.3
ONE, OTHER = np.array([0]), np.array([1])


def pair(apart, confirmed):
    table = TrackTable.blank(2, 3)
    table.track_id = [3, 7]
    table.mean[1, 0] = apart
    table.confirmed = confirmed
    return table


def joined_after(table):
    """Return after how long, s, and how, two tracks become one that nothing tells apart."""
    watch = DuplicateWatch(DISTANCE_M, ENOUGH_S)
    for tick in range(500):
        found = watch.find(table, ONE, OTHER, TICK_S)
        if found:
            return tick * TICK_S, found
    return np.inf, []


def test_the_nearer_two_are_the_sooner_they_are_one():
    waited = [joined_after(pair(apart, True))[0] for apart in (0.0, 0.5, 0.9)]
    assert waited == pytest.approx([1.3, 2.6, 13.0], abs=2 * TICK_S)


def test_two_that_nobody_has_confirmed_are_one_almost_at_once():
    assert joined_after(pair(0.1, False))[0] == pytest.approx(0.2, abs=TICK_S)
    assert joined_after(pair(0.1, [True, False]))[0] > ENOUGH_S


def test_who_is_confirmed_stays_else_the_elder():
    assert joined_after(pair(0.0, True))[1] == [(0, 1)]
    assert joined_after(pair(0.0, [False, True]))[1] == [(1, 0)]


def test_whoever_was_told_apart_begins_anew():
    watch, table = DuplicateWatch(DISTANCE_M, ENOUGH_S), pair(0.0, True)
    for _ in range(20):
        assert not watch.find(table, ONE, OTHER, TICK_S)
    assert not watch.find(table, ONE[:0], OTHER[:0], TICK_S)
    for _ in range(30):
        assert not watch.find(table, ONE, OTHER, TICK_S)
