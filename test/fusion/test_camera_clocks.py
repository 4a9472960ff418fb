"""Clocks that disagree: who is right goes on, whatever another camera's clock does."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fusion_scenes import detections
from mctrack_ros.fusion import JointConfig, JointTracker, open_batcher
from mctrack_ros.fusion.camera_clocks import CameraClocks
from mctrack_ros.fusion.config import BatchingConfig

MS = 1_000_000
SECOND_NS = 1000 * MS
START_NS = 1_700_000_000 * SECOND_NS


def messages(offset_s, count, period_s, phase_s, rng):
    """
    Return (arrival, camera, stamp, true time), all ns, as they arrive.

    ``offset_s(camera, seconds)`` is by how much a camera's clock is ahead; None: no message.
    """
    sent = []
    for index in range(count):
        seconds = phase_s + index * period_s
        true_ns = START_NS + round(seconds * SECOND_NS)
        for camera in sorted(offset_s):
            ahead_s = offset_s[camera](seconds)
            stamp_ns = true_ns + round(ahead_s * SECOND_NS)
            arrival_ns = true_ns + round(rng.uniform(0.008, 0.028) * SECOND_NS)
            sent.append((arrival_ns, camera, stamp_ns, true_ns))
    return sorted(sent)


def fused(sent, cameras, period_s):
    """Return the ticks, and the id under which a person who stands still is known in each."""
    config = JointConfig(batching=BatchingConfig(period=period_s))
    batcher, fusion = open_batcher(config, cameras), JointTracker(config, cameras)
    ticks, ids = [], []

    def fuse(closed):
        for tick in closed:
            tracks = fusion.step(tick).tracks
            ticks.append(tick)
            ids.append([int(i) for i in tracks.track_id[np.isin(tracks.status, (1, 2))]])

    for arrival_ns, camera, stamp_ns, _ in sent:
        while (due_ns := batcher.deadline_ns()) is not None and due_ns <= arrival_ns:
            fuse(batcher.poll(due_ns))
        rows = detections(stamp_ns, [[1.0, 2.0]])
        fuse(batcher.add(camera, rows, arrival_ns, arrival_ns))
    fuse(batcher.flush())
    return ticks, ids, batcher


def assert_nobody_right_loses(offset_s, right, phase_s=0.0, seed=0, settling=3):
    period_s, seconds = 0.04, 6.0
    cameras, rng = tuple(sorted(offset_s)), np.random.default_rng(seed)
    count = round(seconds / period_s)
    sent = messages(offset_s, count, period_s, phase_s, rng)
    ticks, ids, batcher = fused(sent, cameras, period_s)
    admitted = Counter()
    for tick in ticks:
        for index, number in zip(tick.record.camera.tolist(), tick.record.admitted.tolist()):
            admitted[cameras[index]] += number
    for camera in right:
        assert admitted[camera] >= count - settling, camera
    known = [one for some in ids for one in some]
    first = next(index for index, some in enumerate(ids) if some)
    assert len(set(known)) == 1
    assert all(len(some) == 1 for some in ids[first:])
    return ticks, batcher


def constant(offset_s):
    return lambda seconds: offset_s


def jump(offset_s):
    return lambda seconds: offset_s if 2.0 <= seconds < 4.0 else 0.0


def single(offset_s):
    return lambda seconds: offset_s if 3.0 <= seconds < 3.03 else 0.0


def drift(offset_s):
    return lambda seconds: offset_s * seconds / 6.0


KINDS = (constant, jump, single, drift)


@settings(max_examples=10, deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    size=st.floats(-3.5, 3.56),
    ahead=st.booleans(),
    cameras=st.integers(3, 5),
    which=st.integers(0, 4),
    phase_s=st.floats(0.0, 0.04),
    seed=st.integers(0, 9),
)
@example(constant, np.log10(0.05), True, 5, 0, 0.02, 0)
@example(single, np.log10(5.0), True, 5, 2, 0.02, 0)
@example(constant, np.log10(3600.0), True, 3, 0, 0.0, 0)
@example(constant, 0.0, True, 3, 0, 0.0, 2)
@example(constant, np.log10(0.4), True, 3, 0, 0.0, 2)
@example(drift, 1.5, True, 3, 0, 0.03125, 2)
def test_one_camera_with_whatever_clock_costs_the_others_nothing(
    kind, size, ahead, cameras, which, phase_s, seed
):
    names = tuple(f'cam{index}' for index in range(cameras))
    wrong = names[which % cameras]
    offset_s = dict.fromkeys(names, constant(0.0))
    offset_s[wrong] = kind(10**size * (1 if ahead else -1))
    right = [name for name in names if name != wrong]
    assert_nobody_right_loses(offset_s, right, phase_s=phase_s, seed=seed)


@pytest.mark.parametrize('phase_s', [0.0, 0.01, 0.02, 0.03])
@pytest.mark.parametrize('offset_s', [0.02, 0.05, 0.12, 0.19, -0.02, -0.05, -0.12, -0.19])
def test_an_offset_up_to_the_limit_is_removed_and_costs_nobody_anything(offset_s, phase_s):
    clocks = dict.fromkeys(('cam1', 'cam2', 'cam3', 'cam4'), constant(0.0))
    clocks['cam5'] = constant(offset_s)
    ticks, batcher = assert_nobody_right_loses(clocks, ['cam1', 'cam5'], phase_s=phase_s)
    added_ms = int(ticks[-1].record.added_ms[4])
    assert abs(added_ms + offset_s * 1000) <= 12 or (added_ms == 0 and abs(offset_s) < 0.04)
    assert batcher.clocks.offset_s('cam5') == pytest.approx(offset_s, abs=0.012)
    assert not batcher.clocks.is_left_out('cam5')


@pytest.mark.parametrize('offset_s', [3600.0, -3600.0, 0.5, 5.0])
@pytest.mark.parametrize('wrong', ['cam1', 'cam2'])
def test_of_two_cameras_the_one_near_the_arrival_is_kept(offset_s, wrong):
    clocks = {'cam1': constant(0.0), 'cam2': constant(0.0)} | {wrong: constant(offset_s)}
    right = 'cam2' if wrong == 'cam1' else 'cam1'
    settling = 15 if abs(offset_s) < 1 else 3
    _, batcher = assert_nobody_right_loses(clocks, [right], settling=settling)
    assert batcher.clocks.is_left_out(wrong) == (abs(offset_s) >= 1.0 or offset_s > 0)
    assert not batcher.clocks.is_left_out(right)
    assert batcher.clocks.offset_s(wrong) == pytest.approx(offset_s, abs=0.05)


@pytest.mark.parametrize('offset_s', [-0.3, -0.7, -1.0, -1.01])
@pytest.mark.parametrize('seed', range(4))
def test_a_clock_that_is_set_back_is_left_out_soon_and_until_it_is_right(offset_s, seed):
    """By exactly a second, too: a slow camera may be that late, but its stamps do not go back."""
    cameras = {'cam1': constant(0.0), 'cam2': constant(0.0), 'cam3': jump(offset_s)}
    clocks, wrong_s = CameraClocks(BatchingConfig(), tuple(cameras)), []
    for arrival_ns, camera, stamp_ns, true_ns in messages(
        cameras, 150, 0.04, 0.0, np.random.default_rng(seed)
    ):
        clocks.judge(camera, stamp_ns, arrival_ns)
        if clocks.is_left_out('cam3'):
            wrong_s.append((true_ns - START_NS) / SECOND_NS)
        assert not clocks.is_left_out('cam1')
    assert 2.0 < min(wrong_s) < 3.5
    assert 3.9 < max(wrong_s) < 4.5
    assert np.diff(wrong_s).max() < 0.05


def test_a_slow_camera_is_not_left_out():
    clocks = CameraClocks(BatchingConfig(), ('cam1', 'cam2', 'slow'))
    for index in range(50):
        stamp_ns = START_NS + index * 40 * MS
        for camera, delay_ms in (('cam1', 10), ('cam2', 12), ('slow', 12 + 14 * index)):
            clocks.judge(camera, stamp_ns, stamp_ns + delay_ms * MS)
    assert clocks.is_behind('slow')
    assert not clocks.is_left_out('slow')
    assert not clocks.is_behind('cam1')


@pytest.mark.parametrize('offset_s', [5.0, 3600.0, -5.0, -3600.0])
def test_a_single_stamp_of_a_single_camera_is_left_out_and_ends_nothing(offset_s):
    ticks, _ = assert_nobody_right_loses({'cam1': single(offset_s)}, ['cam1'])
    assert sum(int(tick.record.left_out[0]) for tick in ticks) == 1


def test_stamps_that_are_strange_one_at_a_time_are_left_out_however_many_there_are():
    clocks = CameraClocks(BatchingConfig(), ('cam1',))
    for index in range(20):
        stamp_ns, is_outlier = START_NS + index * 40 * MS, index % 4 == 3
        verdict = clocks.judge('cam1', stamp_ns + 5 * SECOND_NS * is_outlier, stamp_ns + 10 * MS)
        assert verdict.is_used != is_outlier


def test_all_clocks_that_step_back_together_begin_anew():
    clocks = {f'cam{index}': lambda seconds: -100.0 * (seconds >= 3.0) for index in range(3)}
    sent = messages(clocks, 150, 0.04, 0.0, np.random.default_rng(1))
    ticks, _, _ = fused(sent, tuple(clocks), 0.04)
    assert sum(len(tick.messages) for tick in ticks) >= 150 * 3 - 3 * 3
    assert sum(int(tick.record.late.sum()) for tick in ticks) == 0


def test_a_stall_of_all_cameras_leaves_nobody_out():
    """Messages wait for a second and then come at once; their stamps are right."""
    clocks = dict.fromkeys(('cam1', 'cam2', 'cam3'), constant(0.0))
    sent = [
        (arrival if not 2 <= (true - START_NS) / SECOND_NS < 2.9 else START_NS + 2900 * MS, *rest)
        for arrival, *rest in messages(clocks, 150, 0.04, 0.0, np.random.default_rng(2))
        for true in rest[-1:]
    ]
    ticks, _, _ = fused(sorted(sent), tuple(clocks), 0.04)
    assert sum(int(tick.record.left_out.sum()) for tick in ticks) == 0


@pytest.mark.parametrize('pace', [1.0, 8.0])
def test_a_bag_that_is_played_fast_has_longer_delays_and_no_worse_clocks(pace):
    clocks, added = CameraClocks(BatchingConfig(), ('one', 'two')), set()
    clocks.set_rate(pace)
    for index in range(50):
        for camera, delay_s in (('one', 0.005), ('two', 0.015)):
            stamp_ns = START_NS + index * 40 * MS
            arrival_ns = stamp_ns + round(8.0 * delay_s * SECOND_NS)
            added.add(clocks.judge(camera, stamp_ns, arrival_ns).added_ns)
    assert (added == {0}) == (pace == 8.0)
