"""
What goes to the browser many times a second, as bytes: tracks and images.

All numbers are little-endian. A message begins with 24 bytes: kind (u1), camera (u1), two unused,
count (u4), a time (f8, s since 1970), and another (f8). Kind 1 are tracks of now, kind 2 tracks of
the past from the first time until before the second, kind 3 an image. Rows of tracks follow, 48
bytes each: `ROW`. An image is followed by its boxes, 24 bytes each: `BOX`, and by its JPEG.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.store.rows import TrackRows

NOW, PAST, IMAGE = 1, 2, 3
HEAD = struct.Struct('<BBHIdd')
ROW = np.dtype(
    [
        ('id', '<u4'),
        ('after', '<f4'),
        ('position', '<f4', (2,)),
        ('velocity', '<f4', (2,)),
        ('covariance', '<f4', (3,)),
        ('group', '<u4'),
        ('cameras', '<u4'),
        ('status', 'u1'),
        ('class', 'u1'),
        ('kit', 'u1'),
        ('members', 'u1'),
    ]
)
"""A track: ``after`` is its time after that of the message, s; xx, xy and yy of the covariance."""
BOX = np.dtype([('box', '<f4', (4,)), ('id', '<u4'), ('members', 'u1'), ('unused', 'u1', (3,))])
"""A box: left, top, width and height, px."""
_NO_TIME = 0.0


def tracks_message(tracks: Tracks) -> bytes:
    """Return the message of the tracks of now; deleted ones and those of no place are left out."""
    placed = np.isfinite(tracks.position[:, :2]).all(axis=1)
    kept = tracks.select(placed & (tracks.status != TrackStatus.DELETED))
    rows = np.zeros(len(kept), ROW)
    rows['id'], rows['position'] = kept.track_id, kept.position[:, :2]
    rows['velocity'] = kept.velocity
    rows['covariance'] = kept.covariance[:, [0, 0, 1], [0, 1, 1]]
    rows['group'], rows['cameras'], rows['status'] = kept.group, kept.cameras, kept.status
    rows['class'], rows['kit'], rows['members'] = kept.class_id, kept.kit, kept.member_count
    return HEAD.pack(NOW, 0, 0, len(rows), tracks.stamp_ns / 1e9, _NO_TIME) + rows.tobytes()


def past_message(stored: TrackRows, between_ns: tuple[int, int]) -> bytes:
    """
    Return the message of tracks of the past, which are called by whom they are taken for.

    Parameters
    ----------
    stored : TrackRows
        With all columns, in the order of time.
    between_ns : (int, int)
        From when until before when they are told, ns.

    """
    first_ns, last_ns = between_ns
    rows = np.zeros(len(stored), ROW)
    rows['id'], rows['position'] = stored.life, stored.position()
    rows['after'] = (stored.stamp_ns - first_ns) / 1e9
    rows['velocity'] = stored.column('velocity')
    rows['covariance'] = stored.column('covariance')[:, [0, 0, 1], [0, 1, 1]]
    for name, column in (
        ('group', 'group'),
        ('cameras', 'cameras'),
        ('status', 'status'),
        ('class', 'class_id'),
        ('kit', 'kit'),
        ('members', 'member_count'),
    ):
        rows[name] = stored.column(column)
    return HEAD.pack(PAST, 0, 0, len(rows), first_ns / 1e9, last_ns / 1e9) + rows.tobytes()


def image_message(camera: int, stamp_ns: int, data: bytes, found: Detections | None) -> bytes:
    """Return the message of an image of the camera of a number, JPEG or PNG, with its boxes."""
    boxes = np.zeros(0, BOX) if found is None else _boxes(found)
    head = HEAD.pack(IMAGE, camera, 0, len(boxes), stamp_ns / 1e9, _NO_TIME)
    return head + boxes.tobytes() + data


def _boxes(found: Detections) -> NDArray[np.void]:
    shown = found.select((found.score > 0) & (found.box[:, 2:] > 0).all(axis=1))
    boxes = np.zeros(len(shown), BOX)
    boxes['box'], boxes['id'], boxes['members'] = shown.box, shown.track_id, shown.member_count
    return boxes
