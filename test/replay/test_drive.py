"""Ticks go through fusion one by one, and may depend on what came of those before."""

import pytest

from fusion_scenes import detections, tick
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.interfaces import CameraDetections, Tick
from mctrack_ros.replay.drive import drive

CAMERAS = ('one', 'two', 'three')


def walk(index):
    return tick(index, {name: [[0.1 * index, 2.0]] for name in CAMERAS})


def test_every_tick_gives_what_a_pipeline_makes_of_it():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    for index, ticked in enumerate(drive(JointConfig(), CAMERAS, map(walk, range(20)))):
        tracks = pipeline.step(walk(index)).tracks
        assert ticked.tick.stamp_ns == tracks.stamp_ns
        assert ticked.output.tracks.position.tobytes() == tracks.position.tobytes()
        assert ticked.feedback.position.tobytes() == pipeline.feedback().position.tobytes()
        assert ticked.bias.offset.tolist() == pipeline.bias.offset.tolist()
    assert len(ticked.feedback) == 1


def test_only_what_is_asked_about_is_explained():
    stamps = [walk(index).stamp_ns for index in range(6)]
    driven = drive(
        JointConfig(), CAMERAS, map(walk, range(6)), lambda one: one.stamp_ns >= stamps[4]
    )
    explained = [ticked.explanation for ticked in driven]
    assert explained[:4] == [None] * 4
    assert [each.stamp_ns for each in explained[4:]] == stamps[4:]


def test_a_tick_can_use_the_feedback_of_the_one_before():
    told = []

    def ticks():
        for index in range(10):
            assert [feedback.stamp_ns for feedback in told[-1:]] == [
                walk(before).stamp_ns for before in range(max(index - 1, 0), index)
            ]
            yield walk(index)

    for ticked in drive(JointConfig(), CAMERAS, ticks()):
        told.append(ticked.feedback)
    assert len(told) == 10


def test_a_tick_of_messages_is_in_order_and_as_late_as_the_last():
    late, early = detections(7, [[1.0, 0.0]]), detections(5, [[0.0, 0.0]])
    made = Tick.of([CameraDetections('two', early), CameraDetections('one', late)])
    assert [each.camera for each in made.messages] == ['one', 'two']
    assert made.stamp_ns == made.record.stamp_ns == 7


def test_a_camera_that_is_not_known_is_refused():
    with pytest.raises(ValueError, match='four'):
        list(drive(JointConfig(), CAMERAS, [tick(0, {'four': [[0, 0]]})]))
