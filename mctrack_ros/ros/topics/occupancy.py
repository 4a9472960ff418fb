"""Coverage and likelihoods as occupancy grids, for RViz, Foxglove and Nav2."""

from __future__ import annotations

import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid
from numpy.typing import NDArray
from std_msgs.msg import Header

from mctrack_ros.ground.coverage.raster import Raster
from mctrack_ros.interfaces import Likelihood

UNKNOWN = -1
_MOST = 100


def seen_grid(raster: Raster, frame_id: str) -> OccupancyGrid:
    """Return the share of cameras that see each cell, %; -1 outside the area."""
    share = 100.0 * raster.count / max(len(raster.seen), 1)
    return _grid(raster, np.where(raster.inside, share, np.nan), frame_id)


def error_grid(raster: Raster, frame_id: str) -> OccupancyGrid:
    """Return the fused standard deviation of each cell, cm, 100 for more; -1 if not known."""
    return _grid(raster, 100.0 * raster.fused, frame_id)


def likelihood_grid(likelihood: Likelihood, frame_id: str) -> OccupancyGrid:
    """
    Return the likelihoods of people by a camera, % of those of a perfect outline; -1: not seen.

    Cells of an occupancy grid are square: those of the likelihood's that are longer are repeated.
    """
    rows, columns = likelihood.shape
    place = likelihood.position[:, :2].astype(np.float64).reshape(rows, columns, 2)
    side = (place[-1, -1] - place[0, 0]) / np.maximum([columns - 1, rows - 1], 1)
    cell = float(side.min())
    across, down = np.maximum(np.rint(side * [columns, rows] / cell), 1).astype(int).tolist()
    column = np.minimum(((np.arange(across) + 0.5) * cell / side[0]).astype(int), columns - 1)
    row = np.minimum(((np.arange(down) + 0.5) * cell / side[1]).astype(int), rows - 1)
    share = np.exp(likelihood.log_likelihood.astype(np.float64)).reshape(rows, columns)
    header = Header(frame_id=frame_id, stamp=_time(likelihood.stamp_ns))
    return _message(100 * share[row][:, column], cell, place[0, 0] - side / 2, header)


def _time(stamp_ns: int) -> Time:
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    return Time(sec=seconds, nanosec=nanoseconds)


def _grid(raster: Raster, values: NDArray[np.float64], frame_id: str) -> OccupancyGrid:
    """Return a message; a map holds for all time, so its stamp is zero."""
    return _message(values, float(raster.cell), raster.origin, Header(frame_id=frame_id))


def _message(
    values: NDArray[np.float64], cell: float, corner: NDArray[np.float64], header: Header
) -> OccupancyGrid:
    """Return values of square cells, m, row by row from a corner; NaN: unknown."""
    known = np.isfinite(values)
    whole = np.clip(np.rint(np.where(known, values, 0)), 0, _MOST)
    cells = np.where(known, whole, UNKNOWN).astype(np.int8)
    rows, columns = cells.shape
    data = array.array('b')
    data.frombytes(cells.tobytes())
    x, y = corner.tolist()
    origin = Pose(position=Point(x=x, y=y, z=0.0), orientation=Quaternion(w=1.0))
    info = MapMetaData(resolution=cell, width=columns, height=rows, origin=origin)
    return OccupancyGrid(header=header, info=info, data=data)
