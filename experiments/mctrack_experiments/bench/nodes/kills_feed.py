"""Publish tracks, or detections, at 25 Hz, and take down what was sent and heard, with stamps."""

from __future__ import annotations

import json
import sys
import time
import uuid
from contextlib import suppress

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import Detections, EventCode, Events, Rows, Tracks
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched, reliable

PERIOD_S = 0.04
TRACKS = 25
EVENT_EVERY = 10
"""Ticks between two events."""


def main(path: str, kind: str) -> None:
    """Publish until the process is signalled to end; each line is a word and a stamp, ns."""
    rclpy.init()
    node = rclpy.create_node('kills_feed')
    ids = np.arange(1, TRACKS + 1)
    angles, radii = ids * 2 * np.pi / TRACKS, 10.0 + ids
    with open(path, 'w', buffering=1, encoding='utf-8') as lines:
        site = node.create_publisher(String, '/site', latched())
        tracks = node.create_publisher(PointCloud2, '/tracks', reliable(100))
        events = node.create_publisher(PointCloud2, '/events', reliable(100))
        detections = node.create_publisher(PointCloud2, '/cam1/detections', reliable(100))

        def heard(message: PointCloud2) -> None:
            print('heard', rows_from_cloud(message, Tracks).stamp_ns, file=lines)

        if kind == 'tracks':
            site.publish(String(data=json.dumps({'run': uuid.uuid4().hex, 'cameras': ['cam1']})))
        else:
            node.create_subscription(PointCloud2, '/tracks', heard, reliable(100))
        count = 0

        def send(publisher: object, word: str, rows: Rows) -> None:
            publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))  # type: ignore[attr-defined]
            print(word, rows.stamp_ns, file=lines)

        def tick() -> None:
            nonlocal count
            count += 1
            stamp_ns = time.time_ns()
            turned = angles + 0.1 * count * PERIOD_S
            position = np.column_stack([radii * np.cos(turned), radii * np.sin(turned), 0 * ids])
            if kind == 'detections':
                noise = np.tile(np.eye(2) * 0.01, (TRACKS, 1, 1))
                box = np.tile([10.0, 10.0, 20.0, 50.0], (TRACKS, 1))
                rows = Detections.build(stamp_ns, position=position, covariance=noise, box=box)
                send(detections, 'detections', rows)
                return
            send(tracks, 'tracks', Tracks.build(stamp_ns, track_id=ids, position=position))
            if count % EVENT_EVERY == 0:
                happened = Events.build(stamp_ns, event=[EventCode.NEW], track_id=[1])
                send(events, 'events', happened)

        node.create_timer(PERIOD_S, tick)
        with suppress(KeyboardInterrupt, ExternalShutdownException):
            rclpy.spin(node)


if __name__ == '__main__':
    main(*sys.argv[1:])
