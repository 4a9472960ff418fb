"""A tracker that is registered runs in the nodes, which know nothing of it."""

import pytest
from sensor_msgs.msg import CompressedImage, PointCloud2

import foot_points
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import EventCode, Events, Ticks, Tracks
from mctrack_ros.ros.nodes.camera_node import CameraNode
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from walker import PERIOD_NS, camera_parameters, walker_message

pytestmark = pytest.mark.live

START_NS = 1_700_000_000 * 10**9 + PERIOD_NS // 2


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    foot_points.register(monkeypatch)


def cloud(rows):
    return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


def test_a_camera_node_publishes_what_it_tells_and_takes_its_feedback(bench, projection):
    parameters = camera_parameters(projection)
    parameters['settings']['pipeline'] = {'local_tracker': 'feet', 'contrast': 40}
    node = bench.make(CameraNode, **parameters)
    assert node.has_parameter('settings.pipeline.contrast')
    assert not node.has_parameter('settings.pipeline.background.learning_s')
    told, events = (
        bench.rows(foot_points.FootPoints, '/cam1/foot_points'),
        bench.rows(Events, '/cam1/events'),
    )
    images = bench.publisher(CompressedImage, '/cam1/image_raw/compressed')
    feedback = bench.publisher(PointCloud2, '/headcount')
    bench.heard('/cam1/foot_points')
    bench.heard('/cam1/events')
    for index in range(20):
        stamp_ns = START_NS + index * PERIOD_NS
        before = len(told)
        images.publish(walker_message(index, stamp_ns))
        bench.until(lambda before=before: len(told) > before)
        place = foot_points.Headcount.build(stamp_ns, position=[[1.0, 2.0, 0.0]])
        kept = len(node.feedback._by_tick)
        feedback.publish(cloud(place))
        bench.until(lambda kept=kept: len(node.feedback._by_tick) > kept)
    assert [len(rows) for rows in told[:2]] == [0, 0]
    assert len(told[-1]) == 1
    known = [rows for rows in events if (rows.event == EventCode.STABLE).any()]
    assert known[-1].position.tolist() == [[1.0, 2.0, 0.0]]


def test_a_fusion_node_takes_its_messages_and_tells_its_feedback(bench):
    node = bench.make(
        FusionNode, cameras=['cam1', 'cam2'], fusion={'tracker': 'feet', 'gate': 2.0}
    )
    assert node.has_parameter('fusion.gate')
    assert not node.has_parameter('fusion.management.coast_time')
    tracks, ticks = bench.rows(Tracks, '/tracks'), bench.rows(Ticks, '/ticks')
    feedback = bench.rows(foot_points.Headcount, '/headcount')
    senders = [bench.publisher(PointCloud2, f'/cam{n}/foot_points') for n in (1, 2)]
    for topic in ('tracks', 'ticks', 'headcount'):
        bench.heard(f'/{topic}')
    for index in range(100, 105):
        place = [[0.1 * index, 5.0, 0.0]]
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        before = len(ticks)
        for sender in senders:
            sender.publish(cloud(foot_points.FootPoints.build(stamp_ns, position=place)))
        bench.until(lambda before=before: len(ticks) > before)
    bench.until(lambda: len(tracks) == len(feedback) == 5)
    assert [rows.track_id.tolist() for rows in tracks] == 5 * [[1]]
    assert ticks[-1].detections.tolist() == [1, 1]
    assert feedback[-1].position[0, :2] == pytest.approx([10.4, 5.0])
