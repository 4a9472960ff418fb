"""Fused tracks; truth travels in the same rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.rows import POSITION, Column, Rows


@dataclass(frozen=True, eq=False, slots=True)
class Tracks(Rows):
    """
    Tracks at the stamp of a tick, one row each.

    Attributes
    ----------
    position : (n, 3) float32 array
        Ground position, m.
    velocity : (n, 2) float32 array
        Ground velocity, m/s.
    covariance : (n, 4, 4) float32 array
        Of (x, y, vx, vy), SI units.
    extent : (n, 2) float32 array
        Width and height, m; NaN where not known.
    age : (n,) float32 array
        Time since the first detection, s.
    score : (n,) float32 array
        Confidence, 0 to 1.
    track_id : (n,) uint32 array
        Global id, never reused.
    group : (n,) uint32 array
        Group that the track is in; 0: none.
    cameras : (n,) uint32 array
        Bits of the cameras that saw it this tick; of the cells, where these are fused.
    member_count : (n,) uint8 array
        Physical targets that the track stands for.
    status : (n,) uint8 array
        A `TrackStatus`.
    class_id : (n,) uint8 array
        A `ClassCode`.
    kit : (n,) uint8 array
        Cluster of clothing, 0: not known.

    """

    TOPIC: ClassVar[str] = 'tracks'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'velocity': Column('f4', (2,)),
        'covariance': Column('f4', (4, 4)),
        'extent': Column('f4', (2,), float('nan')),
        'age': Column('f4'),
        'score': Column('f4', (), 1.0),
        'track_id': Column('u4'),
        'group': Column('u4'),
        'cameras': Column('u4'),
        'member_count': Column('u1', (), 1),
        'status': Column('u1', (), 1),
        'class_id': Column('u1'),
        'kit': Column('u1'),
    }

    position: NDArray[np.float32]
    velocity: NDArray[np.float32]
    covariance: NDArray[np.float32]
    extent: NDArray[np.float32]
    age: NDArray[np.float32]
    score: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    group: NDArray[np.uint32]
    cameras: NDArray[np.uint32]
    member_count: NDArray[np.uint8]
    status: NDArray[np.uint8]
    class_id: NDArray[np.uint8]
    kit: NDArray[np.uint8]
