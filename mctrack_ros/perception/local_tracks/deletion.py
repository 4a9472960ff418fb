"""Tracks of which nothing is seen any more; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.geometry.person_size import metre_at

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@compiled(
    types.UniTuple(types.b1[::1], 2)(
        FLOATS_2D, FLOATS_3D, types.f8, types.f8, types.i8, INTS_1D, INTS_1D, BOOLS_1D,
        *[types.f8] * 4,
    )
)  # fmt: skip
def lost_tracks(
    foot: Floats, sizes: Floats, width: float, height: float, stamp_ns: int, seen_ns: Ints,
    clear_ns: Ints, confirmed: Booleans, seconds: float, coast_s: float, confirm_s: float,
    hidden_s: float,
) -> tuple[Booleans, Booleans]:  # fmt: skip
    """
    Return which tracks have left the image, and which were not seen for too long.

    No track is lost before the next image, whatever the frame rate.

    Parameters
    ----------
    foot : (n, 2) array
        Where they are expected, px.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    width, height : float
        Of the image, px.
    stamp_ns : int
        Time of the image, ns.
    seen_ns, clear_ns : (n,) int64 arrays
        Time of the last image with each, and of the last with enough visible pixels, ns.
    confirmed : (n,) bool array
        Which are confirmed.
    seconds : float
        Since the last image, s.
    coast_s, confirm_s, hidden_s : float
        See `TrackerConfig`.

    Returns
    -------
    left, lost : (n,) bool arrays
        Who left, who was lost.

    """
    left, lost = np.empty(len(foot), np.bool_), np.empty(len(foot), np.bool_)
    for row in range(len(foot)):
        x, y = foot[row]
        inside = 0 <= x < width and 0 <= y < height * 1.1
        inside = inside and np.isfinite(metre_at(sizes, x, y)[2])
        unseen = (stamp_ns - seen_ns[row]) * 1e-9
        obscure = (stamp_ns - clear_ns[row]) * 1e-9 - seconds
        left[row] = not inside and unseen > 0.0
        if confirmed[row]:
            lost[row] = unseen > max(coast_s, seconds) or obscure > hidden_s
        else:
            lost[row] = unseen > max(confirm_s, seconds) or obscure > 0.0
    return left, lost
