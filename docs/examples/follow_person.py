"""Send a robot behind one person: `python follow_person.py 12` publishes goals for Nav2."""

import contextlib
import math
import sys

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException
from read_cloud import fields
from sensor_msgs.msg import PointCloud2

DISTANCE_M = 1.2
WALKING_M_S = 0.3
CORRECTION, DELETED = 7, 4


class Follower:
    """Follow the track of an id, also when the id is corrected."""

    def __init__(self, node, track_id):
        self.node, self.track_id, self.heading = node, track_id, 0.0
        self.goals = node.create_publisher(PoseStamped, 'goal_update', 1)
        node.create_subscription(PointCloud2, 'events', self.take_events, 100)
        node.create_subscription(PointCloud2, 'tracks', self.take_tracks, 10)

    def take_events(self, message):
        """Follow corrections; two people who were exchanged come as two in one message."""
        rows = fields(message)
        corrected = rows['event'] == CORRECTION
        renamed = dict(zip(rows['old_id'][corrected], rows['new_id'][corrected]))
        self.track_id = renamed.get(self.track_id, self.track_id)

    def take_tracks(self, message):
        """Publish a goal behind the person, who is at the end of its heading."""
        rows = fields(message)
        ours = (rows['track_id'] == self.track_id) & (rows['status'] != DELETED)
        for row in np.flatnonzero(ours):
            x, y = float(rows['x'][row]), float(rows['y'][row])
            vx, vy = rows['velocity'][row]
            if math.hypot(vx, vy) > WALKING_M_S:
                self.heading = math.atan2(vy, vx)
            goal = PoseStamped(header=message.header)
            goal.pose.position.x = x - DISTANCE_M * math.cos(self.heading)
            goal.pose.position.y = y - DISTANCE_M * math.sin(self.heading)
            goal.pose.orientation.z = math.sin(self.heading / 2)
            goal.pose.orientation.w = math.cos(self.heading / 2)
            self.goals.publish(goal)


def main(track_id):
    """Follow until Ctrl-C."""
    rclpy.init()
    node = rclpy.create_node('follow_person')
    Follower(node, track_id)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main(int(sys.argv[1]))
