"""A slice of the malformed messages: none breaks the codec; in a graph all are counted."""

import os
from pathlib import Path

import pytest

from mctrack_experiments.bench.fuzz import codec, live

BAG = Path(__file__).resolve().parents[3] / 'bags' / 'pitch5_detections'


@pytest.mark.parametrize('seed', [100, 101])
def test_malformed_messages_are_refused_or_read_right(seed):
    outcome = codec.fuzzed(seed, 2000)
    assert outcome.faults == []
    assert outcome.refused.total() + outcome.taken.total() == 2000
    assert outcome.refused.keys() == outcome.taken.keys() == {'cloud', 'raw', 'compressed', 'mask'}


@pytest.mark.live
@pytest.mark.timeout(300)
def test_a_camera_that_sends_garbage_is_counted_and_the_others_go_on(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    figures = live.fuzz_live(BAG, 120, domain=100 + os.getpid() % 100)
    assert figures['live.messages'] == 120
    assert figures['live.uncounted'] == figures['live.exceptions'] == 0
    assert figures['live.restarts'] == 0
    assert figures['live.same_tracks'] == 1
    assert figures['live.ticks'] > 50
