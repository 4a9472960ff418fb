"""The tracker: who starts and ends targets."""

import numpy as np
import pytest

from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.pipeline import BeliefTracker
from mctrack_ros.fusion.inputs import BeliefInput
from mctrack_ros.interfaces import (
    Belief,
    CameraRows,
    Detections,
    EventCode,
    RowsTick,
    Ticks,
    TrackStatus,
)

PERIOD_NS = 40_000_000
CAMERAS = ('east', 'north')


def tick(index, detections=None):
    """Return a tick of cameras that see nobody, or each the same detections."""
    stamp_ns = 10**9 + index * PERIOD_NS
    seen = detections or Detections.build(stamp_ns)
    sighting = BeliefInput(seen.at(stamp_ns), Belief.build(stamp_ns))
    messages = tuple(CameraRows(camera, sighting) for camera in CAMERAS)
    return RowsTick(stamp_ns, messages, Ticks.build(stamp_ns))


def rows(index, **columns):
    return Detections.build(10**9 + index * PERIOD_NS, **columns)


def test_targets_start_and_end_at_the_tick_of_the_stamp():
    tracker = BeliefTracker(BeliefConfig(), CAMERAS, 5)
    tracker.start(rows(2, position=[[1.0, 2.0, 0.0], [3.0, 4.0, 0.0]]))
    tracker.start(rows(4, position=[[np.nan] * 3] * 2, track_id=[6, 99]))
    found = [tracker.step(tick(index)) for index in range(6)]
    assert [each.tracks.track_id.tolist() for each in found] == [
        [],
        [],
        [5, 6],
        [5, 6],
        [5, 6],
        [5],
    ]
    np.testing.assert_allclose(found[2].tracks.position[:, :2], [[1, 2], [3, 4]], atol=0.1)
    assert found[2].events.event.tolist() == [EventCode.NEW] * 2
    assert found[4].tracks.status[1] == TrackStatus.DELETED
    assert found[4].events.track_id.tolist() == [6]
    assert tracker.next_id == 7


def test_who_is_near_a_target_is_taken_for_that_one_but_two_of_one_message_may_be_close():
    tracker = BeliefTracker(BeliefConfig(), CAMERAS)
    tracker.start(rows(0, position=[[1.0, 2.0, 0.0], [1.4, 2.0, 0.0]]))
    tracker.start(rows(1, position=[[1.1, 2.2, 0.0], [3.0, 2.0, 0.0]]))
    found = [tracker.step(tick(index)).tracks.track_id.tolist() for index in range(2)]
    assert found == [[1, 2], [1, 2, 3]]


def somebody_at(x):
    """Return the detection of a person 2 m up the y axis."""
    return rows(
        0,
        position=[[x, 2.0, 0.0]],
        covariance=0.01 * np.eye(2)[None],
        box=[[10, 10, 20, 60]],
        score=[1.0],
        member_count=[1],
    )


def all_seen(tracker, stamp_ns):
    """Return the particles of all targets as a view that sees them, wherever they are."""
    sent = tracker.feedback().at(stamp_ns)
    ground = sent.select(sent.view == 0)
    count = len(ground)
    return ground.replace(
        view=np.full(count, 9, np.uint32),
        covariance=np.tile(np.float32(0.01) * np.eye(2, dtype=np.float32), (count, 1, 1)),
        image_state=np.ones((count, 6), np.float32),
        log_likelihood=np.zeros(count, np.float32),
    )


@pytest.mark.parametrize('is_by_hand', [False, True])
def test_who_was_started_by_detections_ends_without_them_though_a_view_sees_him(is_by_hand):
    tracker, last = BeliefTracker(BeliefConfig(keep_time=1.0), CAMERAS), []
    if is_by_hand:
        tracker.start(rows(0, position=[[1.0, 2.0, 0.0]]))
    for index in range(100):
        detections = somebody_at(1.0) if index < 25 else None
        whole = tick(index, detections)
        sighting = BeliefInput(
            (detections or rows(index)).at(whole.stamp_ns), all_seen(tracker, whole.stamp_ns)
        )
        messages = tuple(CameraRows(camera, sighting) for camera in CAMERAS)
        output = tracker.step(RowsTick(whole.stamp_ns, messages, whole.record))
        last.append(output.tracks.status.tolist())
    assert last[40] == [TrackStatus.CONFIRMED]
    assert ([TrackStatus.DELETED] in last) != is_by_hand
    assert bool(last[-1]) == is_by_hand


def test_who_is_confirmed_by_detections_away_from_all_targets_starts_one():
    tracker = BeliefTracker(BeliefConfig(), CAMERAS)
    seen = somebody_at(1.0)
    tracks = [tracker.step(tick(index, seen)).tracks for index in range(25)]
    assert tracks[-1].track_id.tolist() == [1]
    np.testing.assert_allclose(tracks[-1].position[0, :2], [1, 2], atol=0.3)
    by_boxes_alone = BeliefTracker(BeliefConfig(start=False), CAMERAS)
    for index in range(25):
        assert not len(by_boxes_alone.step(tick(index, seen)).tracks)


def test_without_targets_nobody_is_told_anything():
    tracker = BeliefTracker(BeliefConfig(), CAMERAS)
    assert not len(tracker.step(tick(0)).tracks)
    assert not len(tracker.feedback())


def test_particles_of_another_number_are_left_out():
    tracker = BeliefTracker(BeliefConfig(), CAMERAS)
    tracker.start(rows(0, position=[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]))
    tracker.step(tick(0))
    stamp_ns = 10**9 + PERIOD_NS
    odd = Belief.build(
        stamp_ns,
        position=np.zeros((25, 3)),
        covariance=np.broadcast_to(0.01 * np.eye(2), (25, 2, 2)),
        extent=np.full((25, 2), [1.75, 0.55]),
        track_id=[1] * 20 + [2] * 5,
        view=np.full(25, 9),
    )
    sighting = BeliefInput(Detections.build(stamp_ns), odd)
    tracker.step(RowsTick(stamp_ns, (CameraRows('east', sighting),), Ticks.build(stamp_ns)))
    assert [target.seen_by for target in tracker.ground.targets.values()] == [('east',), ()]


def test_an_unknown_camera_is_refused():
    tracker = BeliefTracker(BeliefConfig(), ('west',))
    with pytest.raises(ValueError, match="camera is 'east'"):
        tracker.step(tick(0))
