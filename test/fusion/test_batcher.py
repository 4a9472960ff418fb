import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from foot_points import FootPoints
from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import Batcher, JointConfig, JointTracker, open_batcher
from mctrack_ros.fusion.config import BatchingConfig

MS = 1_000_000
CAMERAS = ('one', 'three', 'two')


def stamp(index, offset_ms=20):
    return index * PERIOD_NS + offset_ms * MS


def feed(batcher, messages):
    """Give (arrival, camera, stamp) in turn; return the ticks."""
    ticks = []
    for arrival, camera, stamp_ns in messages:
        ticks += batcher.add(camera, detections(stamp_ns, [[0, 0]]), arrival)
    return ticks


def shape(ticks):
    return [
        (
            tick.stamp_ns,
            tuple((message.camera, message.rows.stamp_ns) for message in tick.messages),
        )
        for tick in ticks
    ]


def test_tick_closes_at_once_when_every_camera_has_reported():
    batcher = open_batcher(JointConfig(), CAMERAS)
    assert feed(batcher, [(0, 'two', stamp(5)), (1, 'one', stamp(5, 10))]) == []
    (tick,) = feed(batcher, [(2, 'three', stamp(5, 30))])
    assert tick.stamp_ns == stamp(5, 30)
    assert [message.camera for message in tick.messages] == ['one', 'three', 'two']
    np.testing.assert_array_equal(tick.record.admitted, [1, 1, 1])
    assert batcher.deadline_ns() is None


def test_missing_camera_is_waited_for_and_recorded():
    batcher = open_batcher(JointConfig(), CAMERAS)
    feed(batcher, [(7, 'two', stamp(5)), (8, 'one', stamp(5))])
    deadline = 7 + 32 * MS
    assert batcher.deadline_ns() == deadline
    assert batcher.poll(deadline - 1) == []
    (tick,) = batcher.poll(deadline)
    np.testing.assert_array_equal(tick.record.missing, [0, 1, 0])


def test_late_data_is_dropped_and_counted_in_the_next_tick():
    batcher = open_batcher(JointConfig(), CAMERAS)
    feed(batcher, [(0, 'two', stamp(5)), (0, 'one', stamp(5))])
    batcher.poll(40 * MS)
    assert feed(batcher, [(41 * MS, 'three', stamp(5))]) == []
    (tick,) = feed(batcher, [(42 * MS, name, stamp(6)) for name in CAMERAS])
    np.testing.assert_array_equal(tick.record.late, [0, 1, 0])
    np.testing.assert_array_equal(tick.record.dropped_detections, [0, 1, 0])


def test_dead_camera_is_not_waited_for_once_it_has_timed_out():
    batcher = open_batcher(JointConfig(), CAMERAS)
    for index in range(50):
        now = index * PERIOD_NS
        feed(batcher, [(now, name, stamp(index)) for name in ('one', 'two')])
        waits = batcher.deadline_ns() is not None
        assert waits == (now < 10**9)
        batcher.poll(now + 39 * MS)


def test_slow_camera_is_waited_for_only_where_it_is_due():
    batcher = open_batcher(JointConfig(), ('fast', 'slow'))
    waited = []
    for index in range(20):
        now = stamp(index)
        messages = [(now, 'fast', stamp(index))]
        if index % 2 == 0:
            messages.append((now + MS, 'slow', stamp(index)))
        feed(batcher, messages)
        waited.append(batcher.deadline_ns() is not None)
        batcher.poll(now + 39 * MS)
    assert not any(waited[6:])


@pytest.mark.parametrize('steps', [(1, 4, 2), (3, 1, 4), (2, 1, 2)])
def test_camera_whose_rate_changes_loses_nothing_and_is_soon_waited_for_only_where_due(steps):
    batcher = open_batcher(JointConfig(), ('changing', 'steady'))
    ticks, waited, since, index = [], [], [], 0
    for step in steps:
        for turn in range(12 * step):
            now = stamp(index)
            if turn % step == 0:
                ticks += feed(batcher, [(now, 'changing', stamp(index))])
            ticks += feed(batcher, [(now + MS, 'steady', stamp(index))])
            waited.append(batcher.deadline_ns() is not None)
            since.append(turn // step)
            ticks += batcher.poll(now + 39 * MS)
            index += 1
    assert [len(ticks), sum(len(tick.messages) for tick in ticks)] == [index, index + 36]
    assert sum(int(tick.record.late.sum()) for tick in ticks) == 0
    assert not any(late for late, images in zip(waited, since) if images > 5)


def test_fast_camera_may_report_twice_in_a_tick():
    batcher = open_batcher(JointConfig(), ('fast', 'slow'))
    ticks = []
    for index in range(10):
        now = index * PERIOD_NS
        ticks += feed(batcher, [(now + 5 * MS, 'slow', stamp(index, 5))])
        ticks += feed(batcher, [(now + off * MS, 'fast', stamp(index, off)) for off in (6, 26)])
    assert [len(tick.messages) for tick in ticks[2:]] == [3] * (len(ticks) - 2)
    assert sum(int(tick.record.late.sum()) for tick in ticks[2:]) == 0


def test_duplicates_are_dropped_and_counted():
    batcher = open_batcher(JointConfig(), ('one', 'two'))
    (tick,) = feed(batcher, [(0, 'one', stamp(1)), (1, 'one', stamp(1)), (2, 'two', stamp(1))])
    assert len(tick.messages) == 2
    np.testing.assert_array_equal(tick.record.late, [1, 0])


def test_stamps_that_step_back_a_little_are_late_and_by_much_begin_anew():
    batcher = open_batcher(JointConfig(), ('one',))
    assert len(feed(batcher, [(0, 'one', stamp(100)), (1, 'one', stamp(90))])) == 1
    (again,) = feed(batcher, [(2, 'one', stamp(10))])
    assert again.stamp_ns == stamp(10)
    np.testing.assert_array_equal(again.record.late, [1])


def test_one_camera_that_runs_late_for_good_resets_nothing():
    batcher = open_batcher(JointConfig(), ('late', 'good'))
    ticks = []
    for index in range(100, 200):
        now = index * PERIOD_NS
        ticks += feed(batcher, [(now, 'good', stamp(index)), (now, 'late', stamp(index - 60))])
        ticks += batcher.poll(now + 39 * MS)
    stamps = [tick.stamp_ns for tick in ticks[1:]]
    assert stamps == [stamp(index) for index in range(100, 200)]


def test_it_begins_anew_when_the_camera_that_was_ahead_is_gone():
    batcher = open_batcher(JointConfig(), ('ahead', 'good'))
    feed(batcher, [(0, 'ahead', stamp(1000))])
    batcher.poll(50 * MS)
    ticks = [
        tick
        for index in range(40)
        for tick in feed(batcher, [(60 * MS + index * PERIOD_NS, 'good', stamp(index))])
    ]
    assert len(ticks) > 5


def test_unusable_detections_are_counted():
    batcher = open_batcher(JointConfig(), ('one',))
    rows = detections(stamp(1), [[0, 0], [np.nan, 0], [1, 1]])
    (tick,) = batcher.add('one', rows, 0)
    np.testing.assert_array_equal(tick.record.dropped_detections, [1])


def test_missed_feedback_is_recorded_once():
    batcher = open_batcher(JointConfig(), ('one',))
    batcher.feedback_missed('one', 3)
    ticks = feed(batcher, [(0, 'one', stamp(1)), (1, 'one', stamp(2))])
    assert [int(tick.record.feedback_missed[0]) for tick in ticks] == [3, 0]


def test_unknown_camera_is_refused():
    with pytest.raises(ValueError, match="camera is 'four', expected one of"):
        open_batcher(JointConfig(), CAMERAS).add('four', detections(0, []), 0)


def test_flush_closes_what_is_pending():
    batcher = open_batcher(JointConfig(), CAMERAS)
    feed(batcher, [(0, 'one', stamp(1)), (0, 'one', stamp(2))])
    assert [tick.stamp_ns for tick in batcher.flush()] == [stamp(1), stamp(2)]
    assert batcher.flush() == []


@settings(deadline=None)
@given(st.data())
def test_arrival_order_does_not_change_ticks(data):
    """Messages that come within the wait give the same ticks in whatever order."""
    batcher, reference = (open_batcher(JointConfig(), CAMERAS) for _ in range(2))
    ticks, expected = [], []
    for index in range(4):
        now = index * PERIOD_NS
        messages = [(now, name, stamp(index)) for name in CAMERAS]
        ticks += feed(batcher, data.draw(st.permutations(messages)))
        expected += feed(reference, messages)
    assert shape(ticks) == shape(expected)
    assert len(ticks) == 4


@settings(deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, 60), st.sampled_from(CAMERAS), st.integers(0, 400)), max_size=60
    )
)
def test_ticks_close_in_order_and_nothing_vanishes_uncounted(arrivals):
    batcher = open_batcher(JointConfig(), CAMERAS)
    now, ticks = 0, []
    for wait, camera, stamp_ms in arrivals:
        now += wait * MS
        ticks += batcher.add(camera, detections(stamp_ms * MS, [[0, 0]]), now)
    ticks += batcher.flush()
    indices = [tick.stamp_ns // PERIOD_NS for tick in ticks]
    assert indices == sorted(set(indices))
    admitted = sum(int(tick.record.admitted.sum()) for tick in ticks)
    late = sum(int(tick.record.late.sum()) for tick in ticks)
    assert admitted == sum(len(tick.messages) for tick in ticks)
    assert admitted + late <= len(arrivals)


def test_one_camera_whose_clock_steps_back_is_late_and_takes_nobody_along():
    batcher = open_batcher(JointConfig(), CAMERAS)
    ticks = []
    for index in range(100, 200):
        for camera in CAMERAS:
            back = 1500 * MS if camera == 'two' and index >= 150 else 0
            ticks += feed(batcher, [(stamp(index), camera, stamp(index) - back)])
    assert [tick.stamp_ns for tick in ticks] == [stamp(index) for index in range(100, 200)]
    assert [len(tick.messages) for tick in ticks] == [3] * 50 + [2] * 50
    assert sum(int(tick.record.late[2]) for tick in ticks) >= 49


def test_all_begin_anew_when_the_last_camera_has_stepped_back():
    batcher = open_batcher(JointConfig(), CAMERAS)
    times = [*range(100, 110), *range(10, 20)]
    ticks = [
        tick
        for now, index in enumerate(times)
        for camera in CAMERAS
        for tick in feed(batcher, [(stamp(100 + now), camera, stamp(index))])
    ]
    whole = [tick.stamp_ns for tick in ticks if len(tick.messages) == 3]
    assert whole[-9:] == [stamp(index) for index in range(11, 20)]


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([0.04, 0.1, 0.5, 1.0]),
    st.lists(
        st.tuples(
            st.sampled_from(CAMERAS), st.floats(0.0, 1.5), st.floats(-2.5, 2.5), st.booleans()
        ),
        max_size=40,
    ),
)
@example(1.0, [('one', 0.5, 0.0, False), ('one', 0.0, -1.5, True), ('one', 0.5, 0.0, False)])
def test_whatever_the_clocks_do_fusion_can_take_the_ticks(period, messages):
    config = JointConfig(batching=BatchingConfig(period=period))
    batcher, fusion = open_batcher(config, CAMERAS), JointTracker(config, CAMERAS)
    now_s, offset_s = 100.0, dict.fromkeys(CAMERAS, 0.0)
    for camera, pause_s, step_s, steps in messages:
        now_s += pause_s
        offset_s[camera] += step_s if steps else 0.0
        stamp_ns = round((now_s + offset_s[camera]) * 1e9)
        for tick in feed(batcher, [(round(now_s * 1e9), camera, stamp_ns)]):
            fusion.step(tick)
    for tick in batcher.flush():
        fusion.step(tick)


def test_cameras_that_send_an_image_every_two_seconds_are_waited_for():
    config = JointConfig(batching=BatchingConfig(period=2.0))
    batcher = open_batcher(config, CAMERAS)
    messages = [
        (index * 2000 * MS + wait * MS, camera, index * 2000 * MS + 500 * MS)
        for index in range(6)
        for wait, camera in ((510, 'one'), (520, 'two'), (590, 'three'))
    ]
    ticks = [*feed(batcher, messages), *batcher.flush()]
    assert [len(tick.messages) for tick in ticks] == 6 * [3]


def test_messages_of_any_row_type_are_sorted_into_ticks():
    batcher = Batcher(JointConfig(), ('one', 'two'), unusable=lambda rows: int(rows.area[0] < 0))
    ticks = []
    for index in range(4):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        for camera, area in (('one', 5.0), ('two', -1.0)):
            rows = FootPoints.build(stamp_ns, position=[[1, 2, 0]], area=[area])
            ticks += batcher.add(camera, rows, stamp_ns)
    ticks += batcher.flush()
    assert [tick.messages[0].rows.area.tolist() for tick in ticks] == 4 * [[5.0]]
    assert [tick.record.detections.tolist() for tick in ticks] == 4 * [[1, 1]]
    assert sum(tick.record.dropped_detections for tick in ticks).tolist() == [0, 4]


def test_what_a_clock_is_known_to_be_ahead_is_taken_from_its_stamps_and_recorded():
    batcher = open_batcher(JointConfig(), ('one', 'two'))
    batcher.ahead_ns['two'] = 120 * MS
    (tick,) = feed(batcher, [(0, 'two', stamp(8, 20)), (1, 'one', stamp(5, 25))])
    assert shape([tick]) == [(stamp(5, 25), (('one', stamp(5, 25)), ('two', stamp(5, 20))))]
    np.testing.assert_array_equal(tick.record.added_ms, [0, -120])


def test_a_known_clock_is_not_corrected_by_when_messages_arrive():
    batcher, ticks = open_batcher(JointConfig(), ('one', 'two')), []
    batcher.ahead_ns['two'] = 20 * MS
    for index in range(20):
        for camera, lag_ms in (('one', 0), ('two', 100)):
            stamp_ns = stamp(index) + 20 * MS * (camera == 'two')
            now_ns = stamp(index) + lag_ms * MS
            ticks += batcher.add(camera, detections(stamp_ns, [[0, 0]]), now_ns, now_ns)
    assert ticks
    assert {int(tick.record.added_ms[1]) for tick in ticks if tick.record.admitted[1]} <= {-20}
    assert not any(tick.record.added_ms[0] for tick in ticks)
