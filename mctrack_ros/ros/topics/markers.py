"""Tracks as messages that RViz, Foxglove and Nav2 know."""

from __future__ import annotations

import math
from collections import deque
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
from mctrack_ros.interfaces import Column, Rows, Tracks, TrackStatus, starts_anew
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.tracking.colours import track_colour

_LIFETIME = Duration(seconds=1)
_LARGEST_ID = 0x7FFFFFFF
_PARTS = {
    'body': Marker.CYLINDER,
    'name': Marker.TEXT_VIEW_FACING,
    'covariance': Marker.CYLINDER,
    'trail': Marker.LINE_STRIP,
}
"""Namespaces of a track's markers, and their types."""
_WITHIN_95 = math.sqrt(5.991)
"""Standard deviations that hold 95 % of a normal distribution in the plane."""
_FLAT_M, _TRAIL_WIDTH_M = 0.02, 0.06
_TRAIL_STEP_NS = 200_000_000
_WIDTH_M, _HEIGHT_M = 0.5, 1.8
_POINTS_A_DISC = 12
_DISC_M = 0.3
"""Radius that a disc has at least, m."""


@dataclass(frozen=True, eq=False, slots=True)
class _Points(Rows):
    """Nothing but positions, m."""

    COLUMNS: ClassVar[dict[str, Column]] = {'position': Column('f4', (3,))}


class TrackMarkers:
    """
    Tracks as markers, tick after tick.

    Of every track a cylinder, faded while it is unseen, its id in its kit's colour, the ellipse
    that holds its place with 95 %, and the trail of the last seconds. Markers of tracks that are
    over are deleted.

    Parameters
    ----------
    frame_id : str
        The ground frame.
    trail_s : float
        Length of the trails, s; may change.

    """

    def __init__(self, frame_id: str, trail_s: float) -> None:
        self._frame_id, self.trail_s = frame_id, trail_s
        self._trails: dict[int, deque[tuple[int, float, float]]] = {}
        self._last_ns = 0

    def array(self, tracks: Tracks) -> MarkerArray:
        """Return what changes with the tracks of a tick."""
        shown, stamp_ns = MarkerArray(), tracks.stamp_ns
        if starts_anew(stamp_ns, self._last_ns):
            self._trails.clear()
            shown.markers.append(Marker(action=Marker.DELETEALL))
        self._last_ns, known = stamp_ns, set(self._trails)
        for row in np.nonzero(_alive(tracks))[0].tolist():
            shown.markers += self._of_track(tracks, row)
            known.discard(int(tracks.track_id[row]))
        for track_id in sorted(known):
            del self._trails[track_id]
            shown.markers += [
                Marker(
                    header=header(RCLPY_CLASSES, stamp_ns, self._frame_id),
                    ns=name,
                    id=track_id & _LARGEST_ID,
                    action=Marker.DELETE,
                )
                for name in _PARTS
            ]
        return shown

    def _of_track(self, tracks: Tracks, row: int) -> list[Marker]:
        """Return the markers of one track."""
        body, name, ellipse, trail = (
            _marker(tracks, self._frame_id, row, part, kind) for part, kind in _PARTS.items()
        )
        name.text = str(int(tracks.track_id[row]))
        name.pose.position.z = body.scale.z + 0.3
        name.color = _colour(int(tracks.kit[row]) or int(tracks.track_id[row]), 1.0)
        length, width, turn = _ellipse(tracks.covariance[row, :2, :2].astype(np.float64))
        ellipse.scale = Vector3(x=length, y=width, z=_FLAT_M)
        ellipse.pose.position.z, ellipse.pose.orientation = 0.0, _turned(turn)
        ellipse.color.a = 0.35 * body.color.a
        trail.scale, trail.pose = Vector3(x=_TRAIL_WIDTH_M), Pose()
        trail.points = self._trail(tracks, row)
        return [body, name, ellipse, trail] if len(trail.points) > 1 else [body, name, ellipse]

    def _trail(self, tracks: Tracks, row: int) -> list[Point]:
        """Return where a track was in the last seconds."""
        x, y = tracks.position[row, :2].tolist()
        trail = self._trails.setdefault(int(tracks.track_id[row]), deque())
        if not trail or tracks.stamp_ns - trail[-1][0] >= _TRAIL_STEP_NS:
            trail.append((tracks.stamp_ns, x, y))
        while trail and trail[0][0] < tracks.stamp_ns - self.trail_s * 1e9:
            trail.popleft()
        return [Point(x=at_x, y=at_y, z=_FLAT_M) for _, at_x, at_y in trail]


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
        id=track_id & _LARGEST_ID,
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


def _ellipse(covariance: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return both axes, m, and the turn, rad, of what holds 95 % of a (2, 2) covariance, m²."""
    variance, axes = np.linalg.eigh(covariance)
    width, length = (2 * _WITHIN_95 * np.sqrt(np.maximum(variance, 1e-6))).tolist()
    return length, width, math.atan2(axes[1, 1], axes[0, 1])


def _facing(vx: float, vy: float) -> Quaternion:
    return _turned(math.atan2(vy, vx))


def _turned(angle: float) -> Quaternion:
    return Quaternion(x=0.0, y=0.0, z=math.sin(angle / 2), w=math.cos(angle / 2))
