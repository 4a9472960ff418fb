"""What a tick says for and against tracks, reckoned by hand."""

import numpy as np
import pytest

from fusion_scenes import detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.config import CORRELATED_S
from mctrack_ros.fusion.existence.evidence import MISS_WEIGHT, MOST_EVIDENCE, Evidence
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable

LIFE = ManagementConfig(hit_evidence=2.0)
CONFIG = JointConfig(management=LIFE)
SECONDS = 0.1
SHARE = SECONDS / CORRELATED_S
HIT, MISS = SHARE * LIFE.hit_evidence, -SHARE * np.log(1 - LIFE.coverage_prior)
"""What one camera adds and takes away in a tick, where nothing is known of the place yet."""
CAMERAS = 4
EVERY = tuple(range(CAMERAS))


def one_track(evidence=3.0, missed=2.0, confirmed=True):
    table = TrackTable.blank(1, CAMERAS)
    table.track_id[:], table.confirmed[:] = 7, confirmed
    table.evidence[:], table.missed[:] = evidence, missed
    return table


def count(weigher, table, tick, seen=(), grouped=(), present=EVERY):
    """Let a tick pass of which some cameras have images; tell whether it confirms."""
    stamp_ns = round(tick * SECONDS * 1e9)
    table.cameras[:] = sum(1 << camera for camera in seen)
    table.hidden_ns[:, list(grouped)] = stamp_ns
    if seen or grouped:
        table.kept_ns[:] = stamp_ns
    images = [detections(stamp_ns, []) for _ in present]
    batch = Batch(images, present, stamp_ns, CONFIG)
    return bool(weigher.count(table, batch, stamp_ns, SECONDS)[0])


@pytest.mark.parametrize(
    ('told', 'gain', 'missed'),
    [
        ({'seen': [0]}, HIT - MISS_WEIGHT * 3 * MISS, 2 - HIT),
        ({'seen': [0, 1]}, 2 * HIT, 0),
        ({'seen': [0], 'grouped': [2]}, HIT - MISS_WEIGHT * 2 * MISS, 2 - HIT),
        ({'seen': [0], 'present': [0, 3]}, HIT - MISS_WEIGHT * MISS, 2 - HIT),
        ({'seen': [3], 'present': [3]}, HIT, 0),
        ({}, 0, 2 + 4 * MISS),
        ({'grouped': [1]}, 0, 2 - HIT),
        ({'present': []}, 0, 2),
    ],
)
def test_one_tick_where_nothing_is_known(told, gain, missed):
    """
    What one alone sees the others miss; whom two see nobody misses.

    It tells of his having gone that none sees him; two, or the only one, that he is there.
    """
    table = one_track()
    count(Evidence(CAMERAS, CONFIG), table, 1, **told)
    assert table.evidence[0] == pytest.approx(3 + gain)
    assert table.missed[0] == pytest.approx(missed)


def test_misses_of_who_is_not_confirmed_count_whole_and_down_to_a_floor():
    table = one_track(confirmed=False)
    assert not count(Evidence(CAMERAS, CONFIG), table, 1, seen=[2])
    assert table.evidence[0] == pytest.approx(3 + HIT - 3 * MISS)
    for begun_with, least in ((0.1, 0.0), (-1.0, -1.0)):
        table = one_track(begun_with, confirmed=False)
        count(Evidence(CAMERAS, CONFIG), table, 1, seen=[2])
        assert table.evidence[0] == least


def test_who_has_enough_evidence_is_confirmed_once():
    table = one_track(LIFE.confirm_evidence - 2 * HIT, confirmed=False)
    weigher = Evidence(CAMERAS, CONFIG)
    assert [count(weigher, table, tick, seen=[1, 2]) for tick in (1, 2)] == [True, False]
    assert table.confirmed[0]


def test_evidence_and_misses_are_bounded():
    weigher, table = Evidence(CAMERAS, CONFIG), one_track()
    for tick in range(1, 20):
        count(weigher, table, tick, seen=[0, 1])
    assert table.evidence[0] == MOST_EVIDENCE
    for tick in range(20, 70):
        count(weigher, table, tick)
    assert table.missed[0] == MOST_EVIDENCE


def test_whom_the_latest_image_of_a_slow_camera_shows_has_not_gone():
    """Camera 1 sends every fifth tick; one that is silent for long shows nobody."""
    weigher, table = Evidence(CAMERAS, CONFIG), one_track(missed=0.0)
    fast, paces = [0, 2, 3], []
    for tick in range(1, 11):
        seen = [1] * (tick % 5 == 0)
        count(weigher, table, tick, seen=seen, present=EVERY if seen else fast)
        paces.append(table.pace_s[0])
        if tick == 5:
            table.missed[:] = 0.0
        if tick > 5:
            assert table.missed[0] == 0.0
    assert paces[-1] == pytest.approx(0.5)
    count(weigher, table, 11, present=fast)
    assert table.missed[0] == 0.0
    for tick in range(12, 40):
        count(weigher, table, tick, present=fast)
    assert table.missed[0] > 0.0


def test_an_image_of_a_slow_camera_counts_for_all_the_time_since_its_last_up_to_a_look():
    weigher, table = Evidence(CAMERAS, CONFIG), one_track(0.0)
    count(weigher, table, 1, present=EVERY)
    gains = []
    for tick in range(2, 15):
        before = table.evidence[0]
        slow = tick in (4, 14)
        count(weigher, table, tick, seen=[1] * slow, present=[1] * slow)
        gains.append(table.evidence[0] - before)
    assert gains[2] == pytest.approx(min(3 * SHARE, 1) * LIFE.hit_evidence)
    assert gains[12] == pytest.approx(LIFE.hit_evidence)
    assert sum(gains) == pytest.approx(gains[2] + gains[12])
