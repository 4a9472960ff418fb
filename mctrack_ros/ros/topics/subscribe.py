"""Clouds of a running graph, one after another, for `mctrack echo`."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2

from mctrack_ros.ros.node.silence import warn_of_silence

_QUEUE = 100


def clouds(topic: str) -> Iterator[Any]:
    """Yield the `PointCloud2` messages of a topic as they come, until Ctrl-C."""
    arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
    yielded = 0
    rclpy.init()
    node = rclpy.create_node('mctrack_echo')
    quality = QoSProfile(depth=_QUEUE, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(PointCloud2, topic, arrived.put, quality)
    warn_of_silence(node, topic, lambda: yielded > 0)
    try:
        while rclpy.ok():
            rclpy.spin_once(node)
            while not arrived.empty():
                yielded += 1
                yield arrived.get()
    except (KeyboardInterrupt, ExternalShutdownException):
        return
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
