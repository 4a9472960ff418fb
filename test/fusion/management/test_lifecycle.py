"""Who ends, and who is still told of: by how long and by how slow a camera saw him."""

import pytest

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.config import BatchingConfig
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.management.lifecycle import (
    GROUP_MEMORY_S,
    is_expected,
    is_over,
    is_published,
    leave_groups,
)
from mctrack_ros.fusion.table import TrackTable

LIFE = ManagementConfig(tentative_time=0.2, report_time=0.5, coast_time=1.0)
CONFIG = JointConfig(management=LIFE)
SLOW_TICKS = JointConfig(batching=BatchingConfig(period=2.0), management=LIFE)
NOW_NS = 90_000_000_000


def silent_for(seconds, **columns):
    """Return a track that nothing has supported for so long."""
    table = TrackTable.blank(1, 2)
    table.kept_ns[:] = NOW_NS - round(seconds * 1e9)
    for name, value in columns.items():
        getattr(table, name)[:] = value
    return table


@pytest.mark.parametrize(
    ('told', 'longest_s', 'config'),
    [
        ({'confirmed': True}, 1.0, CONFIG),
        ({'confirmed': True, 'pace_s': 0.3}, 1.0, CONFIG),
        ({'confirmed': True, 'pace_s': 1.0}, 2.5, CONFIG),
        ({'confirmed': True}, 3.0, SLOW_TICKS),
        ({'evidence': -1.0}, 0.2, CONFIG),
        ({'pace_s': 1.0}, 0.2, CONFIG),
        ({'pace_s': 1.0, 'shown_by': 2}, 2.5, CONFIG),
        ({}, 3.0, SLOW_TICKS),
    ],
)
def test_a_track_ends_when_nothing_has_supported_it_for_longer(told, longest_s, config):
    assert not is_over(silent_for(longest_s, **told), NOW_NS, config)[0]
    assert is_over(silent_for(longest_s + 0.001, **told), NOW_NS, config)[0]


def test_a_confirmed_track_ends_when_the_evidence_is_against_it():
    for evidence, over in ((0.0, False), (-0.001, True)):
        table = silent_for(0.0, confirmed=True, evidence=evidence)
        assert is_over(table, NOW_NS, CONFIG)[0] == over


@pytest.mark.parametrize(
    ('pace_s', 'longest_s', 'config'),
    [(0.0, 0.5, CONFIG), (0.2, 0.5, CONFIG), (1.0, 1.5, CONFIG), (0.0, 3.0, SLOW_TICKS)],
)
def test_a_target_is_expected_and_told_of_for_an_image_and_a_half(pace_s, longest_s, config):
    for silent_s, told in ((longest_s, True), (longest_s + 0.001, False)):
        table = silent_for(silent_s, pace_s=pace_s)
        assert is_expected(table, NOW_NS, config)[0] == told
        assert is_published(table, NOW_NS, config)[0] == told


def test_who_has_most_probably_gone_is_expected_but_not_published():
    for missed, told in ((4.999, True), (5.0, False)):
        table = silent_for(0.0, missed=missed)
        assert is_expected(table, NOW_NS, CONFIG)[0]
        assert is_published(table, NOW_NS, CONFIG)[0] == told


def test_a_group_is_left_when_no_camera_has_seen_it_for_a_while():
    for silent_s, group in ((GROUP_MEMORY_S, 4), (GROUP_MEMORY_S + 0.001, 0)):
        table = silent_for(0.0, group=4, group_ns=NOW_NS - round(silent_s * 1e9))
        leave_groups(table, NOW_NS)
        assert table.group.tolist() == [group]
