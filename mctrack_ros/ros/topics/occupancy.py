"""Coverage as occupancy grids, for RViz, Foxglove and Nav2."""

from __future__ import annotations

import array

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid
from numpy.typing import NDArray
from std_msgs.msg import Header

from mctrack_ros.ground.coverage.raster import Raster

UNKNOWN = -1
_MOST = 100


def seen_grid(raster: Raster, frame_id: str) -> OccupancyGrid:
    """Return the share of cameras that see each cell, %; -1 outside the area."""
    share = 100.0 * raster.count / max(len(raster.seen), 1)
    return _grid(raster, np.where(raster.inside, share, np.nan), frame_id)


def error_grid(raster: Raster, frame_id: str) -> OccupancyGrid:
    """Return the fused standard deviation of each cell, cm, 100 for more; -1 if not known."""
    return _grid(raster, 100.0 * raster.fused, frame_id)


def _grid(raster: Raster, values: NDArray[np.float64], frame_id: str) -> OccupancyGrid:
    """Return a message; a map holds for all time, so its stamp is zero."""
    known = np.isfinite(values)
    whole = np.clip(np.rint(np.where(known, values, 0)), 0, _MOST)
    cells = np.where(known, whole, UNKNOWN).astype(np.int8)
    rows, columns = cells.shape
    data = array.array('b')
    data.frombytes(cells.tobytes())
    x, y = raster.origin.tolist()
    origin = Pose(position=Point(x=x, y=y, z=0.0), orientation=Quaternion(w=1.0))
    info = MapMetaData(resolution=float(raster.cell), width=columns, height=rows, origin=origin)
    return OccupancyGrid(header=Header(frame_id=frame_id), info=info, data=data)
