"""The documented node that follows a person, run as it stands."""

import math
import subprocess
import sys

import pytest
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import PointCloud2

from conftest import ROOT
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import EventCode, Events, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

PATIENCE_S = 60.0


def tracks(stamp_ns):
    """Return 12, who walks to the north, and 14, who stands far away."""
    return Tracks.build(
        stamp_ns,
        position=[[2.0, 3.0, 0.0], [40.0, 5.0, 0.0]],
        velocity=[[0.0, 1.0], [0.0, 0.0]],
        track_id=[12, 14],
        status=[TrackStatus.CONFIRMED] * 2,
    )


def test_goals_lie_behind_the_person_also_after_an_exchange_of_ids(bench):
    bench.open()
    command = [sys.executable, ROOT / 'docs' / 'examples' / 'follow_person.py', '12']
    with open(bench.folder / 'follower.log', 'w') as log:
        bench.processes.append(subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log))
    bench.until(lambda: bench.observer.count_subscribers('/tracks'), PATIENCE_S)
    goals = bench.messages(PoseStamped, '/goal_update')
    bench.heard('/goal_update')
    said = {topic: bench.publisher(PointCloud2, topic) for topic in ('/tracks', '/events')}

    def goal_of(topic, rows):
        goals.clear()
        said[topic].publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))
        if topic == '/tracks':
            bench.until(lambda: goals)
        return goals[-1] if goals else None

    first = goal_of('/tracks', tracks(1))
    assert first.header.frame_id == 'map'
    assert (first.pose.position.x, first.pose.position.y) == pytest.approx((2.0, 1.8))
    assert 2 * math.atan2(first.pose.orientation.z, first.pose.orientation.w) == pytest.approx(
        math.pi / 2
    )
    exchanged = Events.build(2, event=[EventCode.CORRECTION] * 2, old_id=[12, 14], new_id=[14, 12])
    goal_of('/events', exchanged)
    bench.until(lambda: goal_of('/tracks', tracks(3)).pose.position.x > 30.0)
    assert bench.processes[0].poll() is None, (bench.folder / 'follower.log').read_text()
