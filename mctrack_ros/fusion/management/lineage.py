"""Lineage: a new track shares the trajectory of the group out of which it came."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.fusion.management.initiation import CROWD_M
from mctrack_ros.fusion.neighbours import nearest
from mctrack_ros.fusion.table import TrackTable

MEMORY_S = 10.0
"""For how long it counts that somebody was lost, s."""

SPEED = 2.0
"""How fast such a one may have gone on, m/s."""

RECENT_S = 0.5
"""A track that nothing has supported for longer is nobody's origin, s."""

Floats = NDArray[np.float64]


def origins(
    begun: Floats, table: TrackTable, lost: tuple[Floats, Floats], stamp_ns: int
) -> NDArray[np.uint32]:
    """
    Find the tracks that new ones were part of until now (event-tracking paper, Definition 6).

    People who came as one object are one track until they split; a track that then begins beside
    it shares its past. If a target was lost near by a short while ago, the new track is taken for
    that target and shares nobody's past.

    Parameters
    ----------
    begun : (k, 2 or more) array
        Where the new ones are, m.
    table : TrackTable
        The tracks.
    lost : pair of (m, 2) and (m,) arrays
        Where those who were lost of late were last, m, and how long ago they were, s.
    stamp_ns : int
        The tick's stamp, ns.

    Returns
    -------
    (k,) uint32 array
        Ids; 0: of none.

    """
    present = table.confirmed & (stamp_ns - table.kept_ns <= RECENT_S * 1e9)
    row, gap = nearest(begun, table.mean, present)
    place, ago_s = lost
    found = (cdist(begun[:, :2], place) < CROWD_M + SPEED * ago_s).any(axis=1)
    origin = np.zeros(len(begun), np.uint32)
    own = (gap < CROWD_M) & ~found
    origin[own] = table.track_id[row[own]]
    return origin
