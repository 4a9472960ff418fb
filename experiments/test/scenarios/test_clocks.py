"""The trials of the time-sync doctor: what is injected, and what nobody can tell."""

import numpy as np

from mctrack_experiments.scenarios.clocks import PERIOD_NS, detected, estimated, ticks_of
from mctrack_ros.simulation import Scenario

SCENARIO = Scenario(seed=3, duration_s=4.0)


def test_a_clock_that_is_ahead_moves_stamps_and_nothing_else():
    messages = detected(SCENARIO)
    assert all(len(images) == 100 for images in messages.values())
    before, after = (list(ticks_of(messages, ahead)) for ahead in ({}, {'cam2': 0.08}))
    first = next(one.rows for one in before[10].messages if one.camera == 'cam2')
    moved = next(one.rows for one in after[12].messages if one.camera == 'cam2')
    assert moved.stamp_ns - first.stamp_ns == 2 * PERIOD_NS
    np.testing.assert_array_equal(moved.position, first.position)


def test_while_nobody_moves_no_clock_is_known():
    found = estimated(detected(SCENARIO, standing=True), {'cam2': 0.12})
    beside = [one for one in found.values() if one.camera != one.reference]
    assert not any(one.is_known for one in beside)
