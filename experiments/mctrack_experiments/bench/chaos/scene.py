"""People whom three detectors see, one on a video, one in a bag: the input of a small graph."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import TEMPLATE_SIZE, Detections
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

Floats = NDArray[np.float64]

CAMERA = 'door'
"""The camera whose images are those of a video; nobody else sees what it sees."""
PLAYED = 'gate'
"""The camera whose detections are played from a bag; nobody else sees whom it sees."""
DETECTORS = ('east', 'north', 'west')
PERIOD_S = 0.1
_PEOPLE = 4
_SIZE = (192, 144)
_DOOR_X = 100.0
_AT_GATE = (-100.0, 0.0)
_VIDEO_S, _BAG_S = 5 * math.pi, 10.0
"""Both begin again at their end; the walker of the video is where he began then."""
_NOISE_M = 0.05
_CLOTHES = np.random.default_rng(3).dirichlet(np.full(TEMPLATE_SIZE, 0.2), _PEOPLE)
"""Colours of each person. Without any, prediction alone has to find again who walked round a
circle while fusion was away, and after some 5 s it does not."""


def people(stamp_s: float) -> Floats:
    """Return where people are, (4, 2), m: each walks round a circle of 2 m at 0.8 m/s."""
    angle = 0.4 * stamp_s + np.arange(_PEOPLE)
    centre = np.array([[-6.0, -6.0], [6.0, -6.0], [-6.0, 6.0], [6.0, 6.0]])
    return centre + 2.0 * np.column_stack([np.cos(angle), np.sin(angle)])


def write_site(folder: Path) -> Path:
    """Write the site of the camera that has images; return its file."""
    matrix = {'image_from_world': _image_from_world().tolist()}
    (folder / 'projection.yaml').write_text(yaml.safe_dump(matrix))
    camera = {
        'image_width': _SIZE[0],
        'image_height': _SIZE[1],
        'calibration': 'projection.yaml',
    }
    site = {
        'cameras': {CAMERA: camera},
        'pipeline': {'background': {'learning_s': 0.2}},
        'fusion': {'batching': {'period': PERIOD_S}},
        'feedback_delay': 2 * PERIOD_S,
    }
    path = folder / 'site.yaml'
    path.write_text(yaml.safe_dump(site))
    return path


def write_video(folder: Path) -> Path:
    """Write what the camera sees; return the file."""
    path = folder / 'door.avi'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 1 / PERIOD_S, _SIZE)
    for index in range(round(_VIDEO_S / PERIOD_S)):
        writer.write(_image(index))
    writer.release()
    return path


def write_bag(folder: Path) -> Path:
    """Write the detections of somebody who stands at the gate; return the bag."""
    path, noise = folder / 'gate', np.random.default_rng(2)
    with BagWriter(path) as writer:
        for index in range(round(_BAG_S / PERIOD_S)):
            stamp_ns = round(index * PERIOD_S * 1e9)
            rows = _detections(stamp_ns, np.array([_AT_GATE]), _CLOTHES[:1], noise)
            message = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
            writer.write(f'/{PLAYED}/detections', message, stamp_ns)
    return path


@dataclass(slots=True)
class Wrong:
    """
    What is wrong with a detector.

    Attributes
    ----------
    is_silent : bool
        Whether it sends nothing.
    late_s : float
        How long after its time each message is sent, s.
    lost : float
        Share of the messages that are not sent.
    ahead_s : float
        By how much its stamps are ahead, s.

    """

    is_silent: bool = False
    late_s: float = 0.0
    lost: float = 0.0
    ahead_s: float = 0.0


class Feed:
    """
    Sends detections at 10 Hz, all that is wrong with them included.

    Parameters
    ----------
    node : Node
        Which sends them; somebody spins it.

    Attributes
    ----------
    wrong : dict of str to Wrong
        What is wrong, by detector.
    lost_s : float
        When the first message was lost, on the steady clock, s.

    """

    def __init__(self, node: Node) -> None:
        self.wrong = {name: Wrong() for name in DETECTORS}
        self._node, self.lost_s = node, math.inf
        self._random = random.Random(1)
        self._noise = np.random.default_rng(1)
        self._waiting: list[tuple[float, Callable[[], None]]] = []
        self._detections = {
            name: node.create_publisher(PointCloud2, f'/{name}/detections', reliable(10))
            for name in DETECTORS
        }
        node.create_timer(PERIOD_S, self._tick)
        node.create_timer(PERIOD_S / 5, self._send_waiting)

    def _tick(self) -> None:
        now_s = time.time()
        stamp_ns = round(now_s * 1e9)
        for name, wrong in self.wrong.items():
            if wrong.is_silent:
                continue
            if self._random.random() < wrong.lost:
                self.lost_s = min(self.lost_s, time.monotonic())
                continue
            message = self._message(stamp_ns, stamp_ns + round(wrong.ahead_s * 1e9))
            publisher: Any = self._detections[name]
            send = lambda p=publisher, m=message: p.publish(m)  # noqa: E731
            self._waiting.append((now_s + wrong.late_s, send))
        self._send_waiting()

    def _send_waiting(self) -> None:
        now_s = time.time()
        due = [send for due_s, send in self._waiting if due_s <= now_s]
        self._waiting = [each for each in self._waiting if each[0] > now_s]
        for send in due:
            send()

    def _message(self, true_ns: int, stamp_ns: int) -> PointCloud2:
        """Return what a detector sees at a time, with another stamp."""
        rows = _detections(stamp_ns, people(true_ns * 1e-9), _CLOTHES, self._noise)
        return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


def _detections(
    stamp_ns: int, seen: Floats, clothes: Floats, noise: np.random.Generator
) -> Detections:
    count = len(seen)
    position = seen + noise.normal(0, _NOISE_M, (count, 2))
    return Detections.build(
        stamp_ns,
        position=np.column_stack([position, np.zeros(count)]),
        covariance=np.tile(np.eye(2) * _NOISE_M**2, (count, 1, 1)),
        box=np.tile([10.0, 10.0, 20.0, 50.0], (count, 1)),
        template=clothes,
    )


def _image_from_world() -> Floats:
    """Return the (3, 4) projection of a camera 4 m above the ground, far from the people."""
    down = np.arctan2(3.0, 10.0)
    forward = np.array([0.0, np.cos(down), -np.sin(down)])
    right = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[200.0, 0, _SIZE[0] / 2], [0, 200.0, _SIZE[1] / 2], [0, 0, 1.0]])
    centre = np.array([_DOOR_X, -10.0, 4.0])
    return np.asarray(intrinsics @ np.column_stack([rotation, -rotation @ centre]))


def _image(index: int) -> NDArray[np.uint8]:
    """Return an image of a dark walker on a light floor, which is empty for a second."""
    image = np.full((_SIZE[1], _SIZE[0], 3), 180, np.uint8)
    noise = np.random.default_rng(index).integers(-3, 4, image.shape)
    if index > 1 / PERIOD_S:
        x = _DOOR_X + 2.0 * np.sin(0.04 * index)
        corners = _image_from_world() @ [[x - 0.3, x + 0.3], [0, 0], [1.8, 0], [1, 1]]
        (left, right), (top, bottom) = np.rint(corners[:2] / corners[2]).astype(int).tolist()
        cv2.rectangle(image, (left, top), (right, bottom), (20, 20, 160), -1)
    return np.asarray(np.clip(image + noise, 0, 255), np.uint8)
