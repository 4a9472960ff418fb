"""Your own detector in place of a camera node: `python detector_node.py hall.yaml north`."""

import contextlib
import sys

import cv2
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CompressedImage, PointCloud2

from mctrack_ros.codec import cloud_from_rows, image_from_message, stamp_ns_of
from mctrack_ros.perception import boxes_to_detections
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.site.site import load_site


def detect(image):
    """Return boxes (left, top, width, height, px) and scores (0 to 1); your detector goes here."""
    dark = cv2.threshold(image.min(axis=2), 100, 255, cv2.THRESH_BINARY_INV)[1]
    boxes = [cv2.boundingRect(outline) for outline in cv2.findContours(dark, 0, 1)[0]]
    return boxes, [0.9] * len(boxes)


def main(site_file, camera):
    """Publish what is detected in each image, also when it is nothing."""
    rclpy.init()
    node = rclpy.create_node(f'{camera}_detector')
    site = load_site(site_file)
    mapping = site.cameras[camera].mapping()
    publisher = node.create_publisher(PointCloud2, f'{camera}/detections', 10)

    def take(message):
        boxes, scores = detect(image_from_message(message))
        rows = boxes_to_detections(boxes, scores, mapping, stamp_ns_of(message))
        publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, site.ground_frame))

    topic = f'{camera}/image_raw/compressed'
    node.create_subscription(CompressedImage, topic, take, qos_profile_sensor_data)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main(*sys.argv[1:])
