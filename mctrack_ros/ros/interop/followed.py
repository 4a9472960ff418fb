"""One person who is followed, as a pose that Nav2 and others take."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion

from mctrack_ros.codec import header
from mctrack_ros.interfaces import (
    REPORTED,
    ClassCode,
    EventCode,
    Events,
    Tracks,
    TrackStatus,
)
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

WALKING_M_S = 0.3
"""Speed below which a target stands, and keeps its direction."""


class Followed:
    """
    Follows the track of an id, also when that is corrected.

    Attributes
    ----------
    track_id : int
        Whom; 0: nobody.

    """

    def __init__(self, track_id: int) -> None:
        self.track_id, self._heading = track_id, 0.0
        self._tracks = Tracks.build(0)

    def choose(self, track_id: int) -> None:
        """Follow somebody else."""
        if track_id != self.track_id:
            self.track_id, self._heading = track_id, 0.0

    def next_id(self) -> int:
        """Return who comes next by id among the confirmed people of the last tick; 0: nobody."""
        tracks = self._tracks
        is_confirmed = np.isin(tracks.status, REPORTED)
        is_person = np.isin(tracks.class_id, (ClassCode.UNKNOWN, ClassCode.PERSON))
        ids = sorted(tracks.track_id[is_confirmed & is_person].tolist())
        return next((each for each in ids if each > self.track_id), ids[0] if ids else 0)

    def pose(self, tracks: Tracks, events: Events, frame_id: str) -> PoseStamped | None:
        """Return where the person is and goes; None: it is not tracked in this tick."""
        self._tracks = tracks
        corrected = np.flatnonzero(events.event == EventCode.CORRECTION)
        renamed = dict(zip(events.old_id[corrected].tolist(), events.new_id[corrected].tolist()))
        self.track_id = renamed.get(self.track_id, self.track_id)
        is_there = (tracks.track_id == self.track_id) & (tracks.status != TrackStatus.DELETED)
        if not self.track_id or not is_there.any():
            return None
        row = int(is_there.argmax())
        (x, y, _), (right, up) = tracks.position[row].tolist(), tracks.velocity[row].tolist()
        if math.hypot(right, up) > WALKING_M_S:
            self._heading = math.atan2(up, right)
        turn = Quaternion(z=math.sin(self._heading / 2), w=math.cos(self._heading / 2))
        return PoseStamped(
            header=header(RCLPY_CLASSES, tracks.stamp_ns, frame_id),
            pose=Pose(position=Point(x=x, y=y), orientation=turn),
        )
