"""Whom a merged detection keeps alive, and where it takes him."""

import numpy as np
import pytest

from fusion_scenes import detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.config import CORRELATED_S
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import motion_of
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.hidden_members import (
    GROUP_INFLATION,
    GROUP_VELOCITY_DENSITY,
    HIDDEN_S,
    keep_members,
)
from mctrack_ros.tracking.kalman import position_matrix, update

CONFIG = JointConfig()
NOW_NS = 90_000_000_000
PLACE, SIGMA = [0.3, 0.2], 0.5
VELOCITY = np.eye(4)[2:]


def tracks(places, seen_s_ago=0.1):
    """Return confirmed tracks 1, 2, ... that were seen a little ago and are not now."""
    table = TrackTable.blank(len(places), 2)
    table.track_id[:] = np.arange(len(places)) + 1
    table.mean[:] = np.column_stack([places, np.tile([1.0, -0.5], (len(places), 1))])
    table.covariance[:] = np.diag([0.2, 0.3, 1.0, 2.0]) + 0.05
    table.confirmed[:] = True
    table.seen_ns[:] = table.kept_ns[:] = NOW_NS - round(seen_s_ago * 1e9)
    return table


def kept(table, count, members=(), shown=(), before_ns=0, place=PLACE):
    """Let camera 1 see a group, and camera 0 some of the tracks; return who is kept by that."""
    stamp_ns, before = NOW_NS - before_ns, table.kept_ns.copy()
    padded = np.zeros((1, 16), np.uint32)
    padded[0, : len(members)] = members
    group = detections(stamp_ns, [place], SIGMA, member_count=[count], members=padded)
    batch = Batch([group], [1], NOW_NS, CONFIG)
    table.cameras[list(shown)] = 1
    free = np.ones((1, len(table)), bool)
    free[0, list(shown)] = False
    keep_members(table, batch, free, CONFIG, motion_of(CONFIG.motion))
    rows = np.flatnonzero(table.hidden_ns[:, 1] == stamp_ns).tolist()
    assert rows == np.flatnonzero(table.kept_ns > before).tolist()
    assert (table.hidden_ns[:, 0] < stamp_ns).all()
    return rows, batch


@pytest.mark.parametrize(
    ('count', 'members', 'shown', 'expected'),
    [
        (2, (), (), [0, 2]),  # the nearest
        (2, (2,), (), [0, 1]),  # who is named goes first
        (3, (1, 2), (0,), [1, 2]),  # one of the three is seen
        (2, (1, 2), (0,), [1]),
        (1, (1,), (0,), []),
        (0, (), (1,), [0, 2]),  # of whom it is not told how many
    ],
)
def test_as_many_are_kept_as_are_hidden_in_the_group(count, members, shown, expected):
    table = tracks([[0.3, 0.2], [1.0, 0.9], [0.6, 0.2], [9.0, 0.0]])
    assert kept(table, count, members, shown)[0] == expected


def test_who_is_not_confirmed_or_expected_elsewhere_is_not_kept():
    table = tracks([[0.3, 0.2], [0.4, 0.2], [4.0, 0.2]])
    table.confirmed[1] = False
    assert kept(table, 3)[0] == [0]


@pytest.mark.parametrize(
    ('seen_s_ago', 'shown', 'expected'),
    [(HIDDEN_S, (0,), [1]), (HIDDEN_S + 0.01, (0,), []), (HIDDEN_S + 0.01, (), [0, 1])],
)
def test_beside_one_who_is_seen_nobody_is_kept_for_long(seen_s_ago, shown, expected):
    table = tracks([[0.3, 0.2], [0.4, 0.2]], seen_s_ago)
    assert kept(table, 2, (1, 2), shown)[0] == expected


def test_all_who_are_hidden_are_one_group_and_who_is_seen_is_free():
    table = tracks([[0.3, 0.2], [0.4, 0.2], [0.5, 0.2]])
    kept(table, 3, (1, 2, 3), shown=(0,))
    assert table.group.tolist() == [0, 1, 1]
    assert table.group_ns[1:].tolist() == [NOW_NS, NOW_NS]
    alone = tracks([[0.3, 0.2]])
    kept(alone, 2)
    assert alone.group.tolist() == [0]


@pytest.mark.parametrize('last_s', [0.05, 100.0])
def test_a_hidden_one_is_hardly_drawn_to_the_middle_and_goes_on_as_the_others_do(last_s):
    """Against two Kalman updates: of the place, and of the velocity, the mean of those shown."""
    table = tracks([[0.3, 0.2], [0.4, 0.2], [0.6, 0.1]])
    table.mean[:2, 2:] = [[2.0, 0.0], [1.0, 1.0]]
    table.hidden_ns[2, 1] = NOW_NS - round((last_s + 0.03) * 1e9)
    before = table.select(np.array([2]))
    rows, batch = kept(table, 3, (1, 2, 3), shown=(0, 1), before_ns=30_000_000)
    assert rows == [2]
    matrix = position_matrix(-0.03)
    innovation = batch.position - before.mean @ matrix.T
    state = update(
        before.mean, before.covariance, innovation, GROUP_INFLATION * batch.noise, matrix
    )
    pull = [1.5, 0.5] - state[0][:, 2:]
    spread = GROUP_VELOCITY_DENSITY / min(last_s, CORRELATED_S) * np.eye(2)
    mean, covariance = update(*state, pull, spread[None], VELOCITY)
    np.testing.assert_allclose(table.mean[2:], mean, atol=1e-9)
    np.testing.assert_allclose(table.covariance[2:], covariance, atol=1e-9)
    np.testing.assert_array_equal(table.mean[:2, 2:], [[2.0, 0.0], [1.0, 1.0]])
