"""What happened: created, entered, split, left, merged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.codes import MEMBERS
from mctrack_ros.interfaces.rows import POSITION, Column, Rows

NO_CAMERA = 0xFFFF
"""Camera of an event that belongs to none."""


@dataclass(frozen=True, eq=False, slots=True)
class Events(Rows):
    """
    Events at one instant, one row each (event-tracking paper, Table 1).

    Attributes
    ----------
    position : (n, 3) float32 array
        Where, m; NaN where not known.
    probability : (n,) float32 array
        Of the event, 0 to 1. Of a camera's: that all whom it names are the right ones. On
        `/events`: the track's score, of an exit the last one; of a correction that the new id is
        the right one, against the next best; of a zone event that the track is on that side of
        the boundary, and 0 where it left as it ended inside.
    track_id : (n,) uint32 array
        The global track it is about; 0: not known.
    old_id, new_id : (n,) uint32 array
        Of a correction: what the track was called, and is called now. Of a split on `/events`:
        whose past the track shares, and itself. Of an occupancy or a crowd: how many were in the
        zone before the tick, and are now.
    local_id : (n,) uint32 array
        The camera's own track; 0: none.
    others : (n, 16) uint32 array
        The other members, zero-padded: global ids on `/events`, local ids on a camera's topic.
    other_tracks : (n, 16) uint32 array
        On a camera's topic, the global ids of the other members in the order of ``others``, 0
        where not known; then those of members without a local track.
    zone : (n,) uint32 array
        Of a zone event, the index of the zone or line, from 1, as `/site` lists them; else 0.
    event : (n,) uint16 array
        An `EventCode`.
    camera : (n,) uint16 array
        Index of the camera in the site's order; ``NO_CAMERA``: none.

    """

    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'probability': Column('f4', (), 1.0),
        'track_id': Column('u4'),
        'old_id': Column('u4'),
        'new_id': Column('u4'),
        'local_id': Column('u4'),
        'others': Column('u4', (MEMBERS,)),
        'other_tracks': Column('u4', (MEMBERS,), absent=0),
        'zone': Column('u4'),
        'event': Column('u2'),
        'camera': Column('u2', (), NO_CAMERA),
    }

    position: NDArray[np.float32]
    probability: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    old_id: NDArray[np.uint32]
    new_id: NDArray[np.uint32]
    local_id: NDArray[np.uint32]
    others: NDArray[np.uint32]
    other_tracks: NDArray[np.uint32]
    zone: NDArray[np.uint32]
    event: NDArray[np.uint16]
    camera: NDArray[np.uint16]
