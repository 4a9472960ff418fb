"""A camera put together from a graph or a bag: camera info and TF."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mctrack_ros.ground.camera.stored import Pose, StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.camera_info import camera_from_info
from mctrack_ros.ground.files.transforms import TransformTree


class HeardCamera:
    """
    What has been heard of one camera so far.

    Parameters
    ----------
    ground : str
        The ground frame.
    pose : Pose, optional
        Where the camera is, if that is known: TF is then not asked.

    """

    def __init__(self, ground: str, pose: Pose | None = None) -> None:
        self._ground, self._pose = ground, pose
        self._info: Any = None
        self._camera: StoredCamera | None = None
        self._tree = TransformTree()

    @property
    def asks_tf(self) -> bool:
        """Whether TF has to tell where the camera is."""
        return self._pose is None

    def hear_info(self, info: Any) -> None:
        """Take a `sensor_msgs/CameraInfo`, rclpy's or rosbags'; the first counts."""
        if self._info is None:
            self._info = info

    def hear_transforms(self, message: Any) -> None:
        """Take a `tf2_msgs/TFMessage`, rclpy's or rosbags'."""
        self._tree.hear(message)

    def camera(self) -> StoredCamera | None:
        """
        Return the camera; None as long as something is missing.

        Raises
        ------
        CalibrationError
            If the info holds no calibration or names no frame, or TF cannot be true.

        """
        if self._info is None:
            return None
        if self._camera is None:
            self._camera = camera_from_info(self._info)
        pose = self._pose
        if pose is None:
            optical = str(self._info.header.frame_id)
            if not optical:
                raise CalibrationError(
                    'the camera info names no frame_id, so TF cannot tell where the camera is: '
                    'name extrinsics'
                )
            pose = self._tree.pose(self._ground, optical)
        return None if pose is None else replace(self._camera, pose=pose)

    def missing(self) -> str:
        """Say what is missing: the info, or a chain of transforms and what there is instead."""
        if self._info is None:
            return 'no sensor_msgs/CameraInfo'
        frames = ', '.join(self._tree.frames) or 'none'
        return (
            f'no transform from {self._ground} to {self._info.header.frame_id} '
            f'(frames in TF: {frames}): name the ground frame, or extrinsics'
        )
