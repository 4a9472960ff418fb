"""What is said of clocks, and how they are corrected by what moves."""

import time
from threading import Event
from unittest.mock import Mock

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from fusion_scenes import detections
from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import JointConfig, open_batcher
from mctrack_ros.fusion.clock_offsets.clock_offsets import ClockOffset, ClockOffsets
from mctrack_ros.fusion.clock_offsets.config import ClocksConfig
from mctrack_ros.interfaces import CameraRows, RowsTick, Ticks, Tracks
from mctrack_ros.ros.node.clock_health import ClockAgreement, ClockJumps, MotionClocks, ahead_from

CAMERAS = ('cam1', 'cam2')
START_NS = 1_700_000_000 * 10**9


def motion(**settings):
    batcher = open_batcher(JointConfig(), CAMERAS)
    return MotionClocks(ClocksConfig(**settings), batcher, ClockOffsets(CAMERAS, 60.0))


def walked(clocks, ahead_ms=50, seconds=45.0):
    """Let people walk in circles before both cameras; wait for an estimate."""
    number = np.arange(6)
    for at in np.arange(0.0, seconds, 0.1):
        stamp_ns = START_NS + round(at * 1e9)

        def places(ahead_s, at=at):
            phase = number + 1.5 * (at - ahead_s) / (2.0 + number)
            circle = np.column_stack([np.cos(phase), np.sin(phase)]) * (2.0 + number)[:, None]
            return circle + np.column_stack([20.0 * number, 0.0 * number])

        images = [CameraRows('cam1', detections(stamp_ns, places(0.0)))]
        images.append(CameraRows('cam2', detections(stamp_ns, places(ahead_ms * 1e-3))))
        where = np.column_stack([places(0.0), 0.0 * number])
        tracks = Tracks.build(stamp_ns, position=where, track_id=number + 1)
        clocks.add(RowsTick(stamp_ns, tuple(images), Ticks.build(stamp_ns)), tracks)
    deadline = time.monotonic() + 60.0
    while not clocks.found and time.monotonic() < deadline:
        time.sleep(0.01)
        clocks.add(RowsTick(stamp_ns, (), Ticks.build(stamp_ns)), Tracks.build(stamp_ns))
    clocks.close()


def test_a_clock_that_is_off_by_what_moves_is_a_warning_with_its_deviation():
    clocks = motion()
    jumps = ClockJumps(clocks.batcher.clocks, clocks)
    assert 'not enough motion' in jumps.report('clocks').message
    walked(clocks)
    status = jumps.report('clocks')
    assert status.level == DiagnosticStatus.WARN
    assert 'cam2 is 0.05' in status.message
    values = {each.key: each.value for each in status.values}
    assert float(values['cam2 offset [s]']) == pytest.approx(0.05, abs=0.005)
    assert float(values['cam2 standard deviation [s]']) < 0.005
    assert not clocks.batcher.ahead_ns


def test_a_clock_is_corrected_only_if_that_is_asked():
    clocks = motion(correct=True)
    walked(clocks)
    assert clocks.batcher.ahead_ns['cam2'] == pytest.approx(50e6, abs=5e6)
    assert clocks.report('clocks').level == DiagnosticStatus.OK
    status = ClockAgreement(clocks.batcher, 'cam2').report('cam2 clock')
    assert 'known to be 0.05' in status.message


def test_a_camera_that_is_far_behind_without_having_gone_back_is_named_and_not_left_out():
    batcher = motion().batcher
    for index in range(20):
        stamp_ns = index * 40_000_000
        for camera, delay_ns in (('cam1', 10_000_000), ('cam2', 10_000_000 + index * 30_000_000)):
            batcher.clocks.judge(camera, stamp_ns, stamp_ns + delay_ns)
    status = ClockAgreement(batcher, 'cam2').report('cam2 clock')
    assert status.level == DiagnosticStatus.WARN
    assert status.message.endswith(': it is slow, or its clock is behind')
    assert ClockAgreement(batcher, 'cam1').report('cam1 clock').level == DiagnosticStatus.OK


def test_a_difference_within_the_limit_or_the_interval_is_none():
    clocks = motion()
    clocks.found = (ClockOffset('cam2', 'cam1', 0.015, 0.001, 0.002),)
    assert clocks.report('clocks').level == DiagnosticStatus.OK
    clocks.found = (ClockOffset('cam2', 'cam1', 0.05, 0.03, 0.06),)
    assert clocks.report('clocks').level == DiagnosticStatus.OK
    clocks.close()


def test_stated_offsets_are_read_in_whole_milliseconds():
    assert ahead_from('cam1=0.0504, cam2=-0.1', CAMERAS) == {'cam1': 50_000_000, 'cam2': -(10**8)}
    assert ahead_from('', CAMERAS) == {}
    with pytest.raises(ConfigError, match="'cam1', expected camera=seconds"):
        ahead_from('cam1', CAMERAS)
    with pytest.raises(ConfigError, match='names cam9'):
        ahead_from('cam9=0.1', CAMERAS)


def test_an_estimate_that_takes_long_holds_up_no_shutdown(monkeypatch):
    clocks, began = motion(), Event()

    def estimate(snapshot, check):
        began.set()
        while True:
            check()

    monkeypatch.setattr(clocks, 'offsets', Mock(estimate=estimate, add=lambda *_: 6))
    clocks.add(RowsTick(START_NS, (), Ticks.build(START_NS)), Tracks.build(START_NS))
    assert began.wait(10.0)
    clocks.close()
    assert clocks.asked.exception() is not None
