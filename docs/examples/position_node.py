"""A sensor that measures positions, and who listens to tracks: `python position_node.py north`."""

import contextlib
import math
import sys

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from read_cloud import fields
from sensor_msgs.msg import PointCloud2, PointField

PERIOD_S = 0.04


def measure(seconds):
    """Return x, y, z (m) and score (0 to 1) of each person; your sensor goes here."""
    return [[3.0 * math.cos(0.3 * seconds), 3.0 * math.sin(0.3 * seconds), 0.0, 0.9]]


def main(camera):
    """Publish who is there, also when it is nobody, and print what fusion makes of it."""
    rclpy.init()
    node = rclpy.create_node(f'{camera}_sensor')
    publisher = node.create_publisher(PointCloud2, f'{camera}/detections', 10)

    def publish():
        now = node.get_clock().now()
        people = np.array(measure(now.nanoseconds * 1e-9), np.float32).reshape(-1, 4)
        message = PointCloud2(height=1, width=len(people), point_step=16)
        message.header.stamp, message.header.frame_id = now.to_msg(), 'map'
        for name, offset in (('x', 0), ('y', 4), ('z', 8), ('score', 12)):
            message.fields.append(PointField(name=name, offset=offset, datatype=7, count=1))
        message.row_step, message.data = 16 * len(people), people.tobytes()
        publisher.publish(message)

    def show(message):
        rows = fields(message)
        for who, x, y in zip(rows['track_id'], rows['x'], rows['y']):
            print(f'{who} is at {x:.2f}, {y:.2f} m', flush=True)

    node.create_timer(PERIOD_S, publish)
    node.create_subscription(PointCloud2, 'tracks', show, 10)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main(*sys.argv[1:])
