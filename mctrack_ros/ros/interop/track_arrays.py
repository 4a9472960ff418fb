"""Tracks as `vision_msgs/Detection3DArray` of version 4."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseWithCovariance, Vector3

from mctrack_ros.codec import header
from mctrack_ros.interfaces import ClassCode, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, message_class

_NAMES = 'Detection3DArray', 'Detection3D', 'BoundingBox3D', 'ObjectHypothesisWithPose'
_WIDTH_M, _HEIGHT_M = 0.5, 1.8
"""Size of a track whose size is not known, m."""
_XX, _XY, _YX, _YY = 0, 1, 6, 7
"""Where the variances and the covariance of x and y stand in a (36,) covariance of a pose."""


class TrackArrays:
    """
    Makes a `Detection3DArray` of tracks.

    Parameters
    ----------
    kinds : mapping of str to type, optional
        Classes of the messages by name; unless given, the installed ones.

    Raises
    ------
    ValueError
        If ``vision_msgs`` is not installed.

    """

    def __init__(self, kinds: Mapping[str, Any] | None = None) -> None:
        kinds = kinds or {name: message_class(f'vision_msgs/msg/{name}') for name in _NAMES}
        self.kind, self._one, self._box, self._result = (kinds[name] for name in _NAMES)

    def array(self, tracks: Tracks, frame_id: str) -> Any:
        """Return all tracks that are not over, each with its id, class, box and covariance."""
        alive = np.flatnonzero(tracks.status != TrackStatus.DELETED).tolist()
        shown = self.kind(header=header(RCLPY_CLASSES, tracks.stamp_ns, frame_id))
        shown.detections = [self._detection(tracks, row, shown.header) for row in alive]
        return shown

    def _detection(self, tracks: Tracks, row: int, head: Any) -> Any:
        width, height = np.where(
            np.isfinite(tracks.extent[row]), tracks.extent[row], (_WIDTH_M, _HEIGHT_M)
        ).tolist()
        x, y = tracks.position[row, :2].tolist()
        spread = np.zeros(36)
        spread[[_XX, _XY, _YX, _YY]] = tracks.covariance[row, :2, :2].ravel()
        pose = Pose(position=Point(x=x, y=y, z=height / 2))
        result = self._result(pose=PoseWithCovariance(pose=pose, covariance=spread))
        result.hypothesis.class_id = ClassCode(int(tracks.class_id[row])).name.lower()
        result.hypothesis.score = min(max(float(tracks.score[row]), 0.0), 1.0)
        box = self._box(center=pose, size=Vector3(x=width, y=width, z=height))
        return self._one(
            header=head, results=[result], bbox=box, id=str(int(tracks.track_id[row]))
        )
