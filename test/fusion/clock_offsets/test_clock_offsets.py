"""Offsets of clocks from targets that move in several views."""

import time

import numpy as np
import pytest

from fusion_scenes import detections
from mctrack_ros.fusion.clock_offsets.clock_offsets import BLOCK_S, ClockOffsets
from mctrack_ros.interfaces import CameraRows, RowsTick, Ticks, Tracks

START_NS = 1_700_000_000 * 10**9
CAMERAS = ('cam1', 'cam2', 'cam3')
TARGETS = 8
SIGMA_M = 0.15


def places(seconds, speed=1.5):
    """Return where the targets are, (n, 2) m: on circles of several sizes."""
    number = np.arange(TARGETS)
    radius = 2.0 + number
    phase = number + speed * seconds / radius
    return np.column_stack([radius * np.cos(phase), 20.0 * number + radius * np.sin(phase)])


def seen(rng, seconds, bias, speed):
    noise = rng.normal(0.0, SIGMA_M, (TARGETS, 2))
    shown = places(seconds, speed) + noise + bias
    return detections(0, shown, SIGMA_M, track_id=np.arange(1, TARGETS + 1))


def told(ahead_s=(), rates=(10.0, 10.0, 10.0), speed=1.5, length_s=40.0, cameras=CAMERAS):
    """Return an estimate that was told what cameras see whose clocks are ahead."""
    rng, offsets = np.random.default_rng(5), ClockOffsets(CAMERAS, 120.0)
    bias = rng.normal(0.0, 0.3, (len(CAMERAS), 2))
    images = []
    for index, (camera, rate) in enumerate(zip(cameras, rates)):
        ahead = dict(ahead_s).get(camera, 0.0)
        for seconds in np.arange(0.01 * index, length_s, 1 / rate):
            images.append((seconds + ahead, camera, seen(rng, seconds, bias[index], speed)))
    for seconds, camera, rows in sorted(images, key=lambda image: image[0]):
        offsets.add_reported(camera, rows.at(START_NS + round(seconds * 1e9)))
    return offsets


@pytest.mark.parametrize('ahead_s', [0.0, -0.02, 0.12])
def test_an_offset_is_found_beside_a_bias_and_at_another_rate(ahead_s):
    offsets = told({'cam2': ahead_s}, rates=(10.0, 25.0, 3.0)).estimate()
    own = {one.camera: one for one in offsets}['cam2']
    found_s = own.offset_s - sum(one.offset_s for one in offsets if one.camera != 'cam2') / 2
    assert found_s == pytest.approx(ahead_s, abs=0.01)
    for one in offsets:
        true_s = ahead_s * ((one.camera == 'cam2') - (one.reference == 'cam2'))
        assert abs(one.offset_s - true_s) <= one.half_s + 1e-12
        assert one.is_known
        assert one.half_s >= 1.9 * one.deviation_s


def test_who_stands_still_tells_nothing_however_often_it_is_seen():
    offsets = told({'cam2': 0.12}, speed=0.0, rates=(25.0, 25.0, 25.0)).estimate()
    known = [one for one in offsets if one.camera != one.reference]
    assert known
    assert not any(one.is_known for one in known)


def test_a_camera_without_common_views_is_named():
    first, second, third = told(cameras=('cam1', 'cam2')).estimate()
    assert (first.reference, second.reference, third.reference) == ('cam1', 'cam1', '')
    assert np.isnan(third.offset_s)
    assert not third.is_known


def test_stamps_that_fusion_corrects_count_as_they_came():
    rng, offsets = np.random.default_rng(5), ClockOffsets(CAMERAS[:2], 120.0)
    velocity = np.zeros((TARGETS, 2))
    for seconds in np.arange(0.0, 40.0, 0.1):
        stamp_ns = START_NS + round(seconds * 1e9)
        rows = [seen(rng, seconds, 0.0, 1.5).at(stamp_ns) for _ in range(2)]
        added = Ticks.build(stamp_ns, camera=[0, 1], added_ms=[0, -80])
        shown = tuple(CameraRows(camera, one) for camera, one in zip(CAMERAS, rows))
        where = np.column_stack([places(seconds), np.zeros(TARGETS)])
        tracks = Tracks.build(
            stamp_ns, position=where, velocity=velocity, track_id=np.arange(1, TARGETS + 1)
        )
        offsets.add(RowsTick(stamp_ns, shown, added), tracks)
    _, own = offsets.estimate()
    assert own.reference == 'cam1'
    assert own.offset_s == pytest.approx(0.08, abs=0.01)


def test_only_the_window_counts_and_time_may_begin_anew():
    offsets = ClockOffsets(CAMERAS, 3 * BLOCK_S)
    rng = np.random.default_rng(1)
    for seconds in np.arange(0.0, 20 * BLOCK_S, 0.5):
        stamp_ns = START_NS + round(seconds * 1e9)
        offsets.add_reported('cam1', seen(rng, seconds, 0.0, 1.5).at(stamp_ns))
    assert offsets.sightings == pytest.approx(3.5 * BLOCK_S / 0.5 * TARGETS, rel=0.3)
    offsets.add_reported('cam1', seen(rng, 0.0, 0.0, 1.5).at(START_NS))
    assert offsets.sightings == TARGETS


def test_an_estimate_ends_as_soon_as_nobody_waits_for_it():
    offsets, checks = told(), []

    def check():
        checks.append(time.monotonic())
        if len(checks) == end:
            raise InterruptedError

    end = -1
    offsets.estimate(check=check)
    assert len(checks) > 20
    total = len(checks)
    for end in (1, total // 2, total):
        checks.clear()
        with pytest.raises(InterruptedError):
            told().estimate(check=check)
        assert len(checks) == end
