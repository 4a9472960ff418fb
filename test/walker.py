"""A small camera and a walker in front of it."""

import cv2
import numpy as np

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

SIZE = (192, 144)
PERIOD_NS = 40_000_000
EMPTY_IMAGES = 10


def image_from_world():
    """Return the (3, 4) projection of a camera 4 m above the ground, 10 m before the walker."""
    down = np.arctan2(3.0, 10.0)
    forward = np.array([0.0, np.cos(down), -np.sin(down)])
    right = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[200.0, 0, SIZE[0] / 2], [0, 200.0, SIZE[1] / 2], [0, 0, 1.0]])
    centre = np.array([0.0, -10.0, 4.0])
    return intrinsics @ np.column_stack([rotation, -rotation @ centre])


IMAGE_FROM_WORLD = image_from_world()


def camera_parameters(projection, **others):
    """Return the parameters of a camera node for small images."""
    settings = {
        'image_width': SIZE[0],
        'image_height': SIZE[1],
        'calibration': str(projection),
        'pipeline': {'background': {'learning_s': 0.2}},
    }
    return {'settings': settings} | others


def walker_image(index):
    """Return a small image of a dark walker on a light floor, which is empty at first."""
    image = np.full((SIZE[1], SIZE[0], 3), 180, np.uint8)
    noise = np.random.default_rng(index).integers(-3, 4, image.shape)
    if index >= EMPTY_IMAGES:
        x = -2.0 + 0.06 * ((index - EMPTY_IMAGES) % 60)
        corners = IMAGE_FROM_WORLD @ [[x - 0.3, x + 0.3], [0, 0], [1.8, 0], [1, 1]]
        (left, right), (top, bottom) = np.rint(corners[:2] / corners[2]).astype(int).tolist()
        cv2.rectangle(image, (left, top), (right, bottom), (20, 20, 160), -1)
    return np.clip(image + noise, 0, 255).astype(np.uint8)


def walker_message(index, stamp_ns, camera='cam1'):
    """Return a walker's image as rclpy sends it."""
    jpeg = jpeg_from_image(walker_image(index))
    return compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, f'{camera}_optical_frame')
