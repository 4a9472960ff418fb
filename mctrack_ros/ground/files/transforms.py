"""What TF says of frames, and where a camera is by it."""

from __future__ import annotations

from typing import Any

import numpy as np

from mctrack_ros.ground.camera.stored import Pose
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.camera_info import pose_from_transform


class TransformTree:
    """
    Frames below frames, from `tf2_msgs/TFMessage`.

    Static and moving transforms are one: the newest of a frame counts.

    """

    def __init__(self) -> None:
        self._above: dict[str, tuple[str, Any]] = {}

    def hear(self, message: Any) -> None:
        """Take a `tf2_msgs/TFMessage`, rclpy's or rosbags'."""
        for each in message.transforms:
            self._above[_name(each.child_frame_id)] = _name(each.header.frame_id), each

    @property
    def frames(self) -> tuple[str, ...]:
        """The names heard so far, sorted."""
        return tuple(sorted({*self._above, *(parent for parent, _ in self._above.values())}))

    def pose(self, ground: str, optical: str) -> Pose | None:
        """
        Return where a camera is.

        Parameters
        ----------
        ground, optical : str
            The ground frame and the camera's optical frame (z forward).

        Returns
        -------
        Pose or None
            From ground to camera axes, m; None while no chain of transforms joins the two.

        Raises
        ------
        CalibrationError
            If the chain holds a transform that is none, or runs in a circle.

        """
        ground_top, ground_pose = self._below_top(_name(ground))
        optical_top, optical_pose = self._below_top(_name(optical))
        if ground_top != optical_top:
            return None
        turn = optical_pose.rotation @ ground_pose.rotation.T
        return Pose(turn, optical_pose.translation - turn @ ground_pose.translation)

    def _below_top(self, frame: str) -> tuple[str, Pose]:
        """Return the topmost frame above one, and the pose that leads down from it."""
        passed = [frame]
        pose = Pose(np.eye(3), np.zeros(3))
        while frame in self._above:
            frame, transform = self._above[frame]
            if frame in passed:
                raise CalibrationError(f'TF runs in a circle: {" -> ".join([*passed, frame])}')
            step = pose_from_transform(transform, f'the transform {frame} -> {passed[-1]}')
            shift = pose.rotation @ step.translation + pose.translation
            pose = Pose(pose.rotation @ step.rotation, shift)
            passed.append(frame)
        return frame, pose


def _name(frame: str) -> str:
    """Return a frame's name; ROS 1 began them with a slash."""
    return str(frame).removeprefix('/')
