"""A camera's calibration from a running graph: its `CameraInfo` and TF."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo

from mctrack_ros.ground import CalibrationError, HeardCamera, StoredCamera
from mctrack_ros.ros.topics.messages import message_class

INFO_TYPE = 'sensor_msgs/msg/CameraInfo'
TF_TYPE = 'tf2_msgs/msg/TFMessage'
_DEPTH = 100


def camera_from_topic(topic: str, heard: HeardCamera, timeout_s: float) -> StoredCamera:
    """
    Wait until a running graph has published all of a camera.

    Parameters
    ----------
    topic : str
        Of its `CameraInfo`.
    heard : HeardCamera
        What is known of it.
    timeout_s : float
        How long at most, s.

    Raises
    ------
    CalibrationError
        If the info holds no calibration, or something is still missing then; says what. At once
        if TF is to be asked and `tf2_msgs` is not installed.

    """
    transforms = _transform_class() if heard.asks_tf else None
    rclpy.init()
    node = rclpy.create_node('mctrack_convert_calibration')
    try:
        _listen(node, CameraInfo, topic, heard.hear_info)
        for name in ('/tf', '/tf_static') if transforms else ():
            _listen(node, transforms, name, heard.hear_transforms)
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=max(0.0, end - time.monotonic()))
            camera = heard.camera()
            if camera is not None:
                return camera
        raise CalibrationError(f'{heard.missing()} within {timeout_s:g} s{_instead(node, topic)}')
    except CalibrationError as error:
        raise CalibrationError(f'{topic}: {error}') from error
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _listen(node: Node, kind: Any, topic: str, heard: Callable[[Any], None]) -> None:
    """Subscribe to what is published now and then, and to what was said once and is kept."""
    live = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
    kept = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    for quality in (live, kept):
        node.create_subscription(
            kind, topic, heard, quality,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )  # fmt: skip


def _transform_class() -> Any:
    try:
        return message_class(TF_TYPE)
    except ValueError as error:
        raise CalibrationError(f'TF cannot be received: {error}: name extrinsics') from error


def _instead(node: Node, topic: str) -> str:
    """Say what the topic, or the graph, has in place of the info that was waited for."""
    kinds = dict(node.get_topic_names_and_types())
    others = [kind for kind in kinds.get(topic, []) if kind != INFO_TYPE]
    if others:
        return f': it holds {others[0]}'
    if node.count_publishers(topic):
        return ''
    found = sorted(
        name for name, held in kinds.items() if INFO_TYPE in held and node.count_publishers(name)
    )
    return f'; nobody publishes on it (camera infos on: {", ".join(found) or "no topic"})'
