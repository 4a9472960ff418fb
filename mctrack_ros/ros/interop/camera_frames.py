"""A camera's place and lens as other packages know them: ``tf_static`` and ``camera_info``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rclpy.lifecycle import LifecyclePublisher
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo

from mctrack_ros.codec import header
from mctrack_ros.ground import CalibrationError, GroundMapping, stored_camera
from mctrack_ros.ros.interop.made_types import TYPES, serialisable, serialised
from mctrack_ros.ros.node.lifecycle import GraphNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched

Floats = NDArray[np.float64]

TF_STATIC, TF_TYPE = 'tf_static', 'tf2_msgs/msg/TFMessage'
OPTICAL_IN_LINK = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Axes of an optical frame (right, down, forward) in a body's (forward, left, up): REP-103."""


class CameraFrames:
    """
    Publishes where a camera stands and what its lens does, once, for those that come later too.

    ``tf_static`` leads from the ground frame to ``<camera>_link`` and on to
    ``<camera>_optical_frame``, the frame of its images. It is in the node's namespace: two sites
    may have cameras of the same names, and each has its own ground.

    Parameters
    ----------
    node : GraphNode
        Being opened.
    camera : str
        Its name.
    ground_frame : str
        The frame that places are told in.
    mapping : GroundMapping
        Its calibration.

    """

    def __init__(
        self, node: GraphNode, camera: str, ground_frame: str, mapping: GroundMapping
    ) -> None:
        self._node, self._camera, self._ground, self._mapping = node, camera, ground_frame, mapping
        quality = latched()
        self._info: LifecyclePublisher = node.publisher(
            CameraInfo, f'{camera}/camera_info', quality
        )
        self._frames: LifecyclePublisher | None = None
        try:
            self._frames = node.publisher(serialisable(TF_TYPE), TF_STATIC, quality)
        except ValueError as error:
            node.get_logger().warning(f'{TF_STATIC} is not published: {error}')

    def publish(self) -> None:
        """Publish both; a calibration without a camera has neither."""
        stamp_ns = self._node.get_clock().now().nanoseconds
        try:
            info = camera_info(self._mapping, self._camera, stamp_ns)
        except CalibrationError as error:
            self._node.get_logger().info(f'neither camera_info nor {TF_STATIC}: {error}')
            return
        self._info.publish(info)
        if self._frames is not None:
            frames = camera_frames(self._mapping, self._camera, self._ground, stamp_ns)
            self._frames.publish(frames)


def camera_info(mapping: GroundMapping, camera: str, stamp_ns: int) -> CameraInfo:
    """
    Return a camera's lens.

    Raises
    ------
    CalibrationError
        If the calibration has no camera.

    """
    stored = stored_camera(mapping)
    across, down, x, y = stored.intrinsics.tolist()
    width, height = mapping.image_size
    return CameraInfo(
        header=header(RCLPY_CLASSES, stamp_ns, f'{camera}_optical_frame'),
        width=int(width),
        height=int(height),
        distortion_model='plumb_bob' if len(stored.distortion) == 5 else 'rational_polynomial',
        d=stored.distortion.tolist(),
        k=[across, 0.0, x, 0.0, down, y, 0.0, 0.0, 1.0],
        r=np.eye(3).ravel().tolist(),
        p=[across, 0.0, x, 0.0, 0.0, down, y, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def camera_frames(mapping: GroundMapping, camera: str, ground_frame: str, stamp_ns: int) -> bytes:
    """
    Return a serialised ``tf2_msgs/TFMessage`` with a camera's link and optical frame.

    Raises
    ------
    CalibrationError
        If the calibration has no camera.

    """
    pose = stored_camera(mapping).pose
    assert pose is not None
    link, optical = f'{camera}_link', f'{camera}_optical_frame'
    body = pose.rotation.T @ OPTICAL_IN_LINK.T
    transforms = [
        _transform(stamp_ns, ground_frame, link, mapping.camera_position, body),
        _transform(stamp_ns, link, optical, np.zeros(3), OPTICAL_IN_LINK),
    ]
    return serialised(TF_TYPE, transforms=transforms)


def _transform(stamp_ns: int, parent: str, child: str, place: Floats, axes: Floats) -> object:
    """Return a ``geometry_msgs/TransformStamped``: a child's place and (3, 3) axes in a parent."""
    types = TYPES.types
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    stamp = types['builtin_interfaces/msg/Time'](sec=seconds, nanosec=nanoseconds)
    turn = dict(zip('xyzw', Rotation.from_matrix(axes).as_quat().tolist()))
    return types['geometry_msgs/msg/TransformStamped'](
        header=types['std_msgs/msg/Header'](stamp=stamp, frame_id=parent),
        child_frame_id=child,
        transform=types['geometry_msgs/msg/Transform'](
            translation=types['geometry_msgs/msg/Vector3'](**dict(zip('xyz', place.tolist()))),
            rotation=types['geometry_msgs/msg/Quaternion'](**turn),
        ),
    )
