"""Tracks as messages that RViz, Foxglove and Nav2 know."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion, Vector3
from numpy.typing import NDArray
from rclpy.duration import Duration
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mctrack_ros.codec import cloud_from_rows, header
from mctrack_ros.interfaces import Column, Rows, Tracks, TrackStatus
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.tracking.colours import track_colour

_LIFETIME = Duration(seconds=1)
_WIDTH_M, _HEIGHT_M = 0.5, 1.8
_POINTS_A_DISC = 12
_DISC_M = 0.3
"""Radius that a disc has at least, m."""


@dataclass(frozen=True, eq=False, slots=True)
class _Points(Rows):
    """Nothing but positions, m."""

    COLUMNS: ClassVar[dict[str, Column]] = {'position': Column('f4', (3,))}


def marker_array(tracks: Tracks, frame_id: str) -> MarkerArray:
    """Return a cylinder for every track, faded while unseen, and its name in its kit's colour."""
    shown = MarkerArray()
    for row in np.nonzero(_alive(tracks))[0].tolist():
        body = _marker(tracks, frame_id, row, 'body', Marker.CYLINDER)
        name = _marker(tracks, frame_id, row, 'name', Marker.TEXT_VIEW_FACING)
        name.text = str(name.id)
        name.pose.position.z = body.scale.z + 0.3
        name.color = _colour(int(tracks.kit[row]) or name.id, 1.0)
        shown.markers += [body, name]
    return shown


def pose_array(tracks: Tracks, frame_id: str) -> PoseArray:
    """Return a pose for every track, turned to where it goes."""
    alive = tracks.select(_alive(tracks))
    poses = [
        Pose(position=Point(x=x, y=y, z=0.0), orientation=_facing(vx, vy))
        for (x, y, _), (vx, vy) in zip(alive.position.tolist(), alive.velocity.tolist())
    ]
    return PoseArray(header=header(RCLPY_CLASSES, tracks.stamp_ns, frame_id), poses=poses)


def obstacle_cloud(tracks: Tracks, frame_id: str, height: float) -> PointCloud2:
    """Return a disc of points at obstacle height (m) for every track, as wide as that is."""
    angle = np.arange(_POINTS_A_DISC) * (2 * np.pi / _POINTS_A_DISC)
    disc = np.column_stack([np.cos(angle), np.sin(angle)])
    alive = _alive(tracks)
    radius = np.fmax(tracks.extent[alive, 0] / 2, _DISC_M)
    centre = tracks.position[alive, :2]
    around = (centre[:, None] + radius[:, None, None] * disc).reshape(-1, 2)
    points = np.column_stack([around, np.full(len(around), height)])
    return cloud_from_rows(
        _Points.build(tracks.stamp_ns, position=points), RCLPY_CLASSES, frame_id
    )


def _alive(tracks: Tracks) -> NDArray[np.bool_]:
    return np.asarray(tracks.status != TrackStatus.DELETED)


def _marker(tracks: Tracks, frame_id: str, row: int, name: str, kind: int) -> Marker:
    x, y = tracks.position[row, :2].tolist()
    width, height = tracks.extent[row].tolist()
    width = width if math.isfinite(width) else _WIDTH_M
    height = height if math.isfinite(height) else _HEIGHT_M
    seen = int(tracks.status[row]) in (TrackStatus.CONFIRMED, TrackStatus.GROUPED)
    track_id = int(tracks.track_id[row])
    is_name = kind == Marker.TEXT_VIEW_FACING
    return Marker(
        header=header(RCLPY_CLASSES, tracks.stamp_ns, frame_id),
        ns=name,
        id=track_id & 0x7FFFFFFF,
        type=kind,
        action=Marker.ADD,
        pose=Pose(position=Point(x=x, y=y, z=height / 2)),
        scale=Vector3(x=width, y=width, z=0.5 if is_name else height),
        color=_colour(track_id, 1.0 if seen else 0.3),
        lifetime=_LIFETIME.to_msg(),
    )


def _colour(number: int, opacity: float) -> ColorRGBA:
    red, green, blue = (part / 255 for part in track_colour(number))
    return ColorRGBA(r=red, g=green, b=blue, a=opacity)


def _facing(vx: float, vy: float) -> Quaternion:
    half = math.atan2(vy, vx) / 2
    return Quaternion(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
