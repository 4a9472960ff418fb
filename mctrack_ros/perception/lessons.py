"""What tracks learn from the persons seen in a picture; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.observations import OBSERVATIONS, Observations
from mctrack_ros.perception.sizes import foot_below, metre_at
from mctrack_ros.perception.whole_blobs import NEW
from mctrack_ros.tracking.kalman import updated

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_TIMES = types.i8[::1]
_TABLE = types.f8[:, ::1]


@compiled(types.void(_TIMES, _TIMES, OBSERVATIONS, types.i8, types.f8))
def note_seen(
    seen_ns: Ints, clear_ns: Ints, seen: Observations, stamp_ns: int, least_proven: float
) -> None:
    """Write when tracks were seen last, and when enough of them was to be sure."""
    for row, track in enumerate(seen.track):
        if track != NEW:
            seen_ns[track] = stamp_ns
            if seen.proven[row] >= least_proven:
                clear_ns[track] = stamp_ns


@compiled(types.UniTuple(types.i8[::1], 3)(OBSERVATIONS, BOOLS_1D, types.f8))
def lessons(
    seen: Observations, truncated: Booleans, least_visible: float
) -> tuple[Ints, Ints, Ints]:
    """
    Tell what of each person is learned, and by which track.

    Parameters
    ----------
    seen : Observations
        The persons.
    truncated : (m,) bool array
        Which blobs touch the picture's edge.
    least_visible : float
        Share of a body that must be seen to measure it.

    Returns
    -------
    place, size, colours : (n,) int64 arrays
        Row of the track that learns where he is, how large, in which colours; -1: none does.

    """
    place, size = np.full(len(seen.track), NEW), np.full(len(seen.track), NEW)
    colours = np.full(len(seen.track), NEW)
    for row, track in enumerate(seen.track):
        if not seen.fitted[row]:
            place[row] = colours[row] = track
            size[row] = NEW if truncated[seen.blob[row]] else track
        elif seen.visible[row] >= least_visible:
            place[row] = track
    return place, size, colours


@compiled(
    types.void(_TABLE, types.f8[:, :, ::1], INTS_1D, FLOATS_2D, FLOATS_3D, FLOATS_2D, FLOATS_3D)
)
def correct(
    mean: Floats, covariance: Floats, rows: Ints, expected: Floats, slope: Floats, foot: Floats,
    noise: Floats,
) -> None:  # fmt: skip
    """
    Correct states with measured foot points; not those that are expected behind the camera.

    Parameters
    ----------
    mean, covariance : (t, 4) and (t, 4, 4) arrays
        Of the tracks; changed in place.
    rows : (n,) int64 array
        Track that each foot point is of; -1: of none.
    expected, slope : (t, 2) and (t, 2, 2) arrays
        Where the tracks are expected, px, and the derivatives by the place, px/m.
    foot, noise : (n, 2) and (n, 2, 2) arrays
        Measured, px, and the covariance, px².

    """
    innovation, is_known = np.zeros((len(rows), 2)), np.zeros(len(rows), np.bool_)
    for index, track in enumerate(rows):
        if track != NEW:
            innovation[index] = foot[index] - expected[track]
            is_known[index] = np.isfinite(innovation[index]).all()
    known = np.flatnonzero(is_known)
    own = rows[known]
    jacobian = np.zeros((len(own), 2, 4))
    jacobian[:, :, :2] = slope[own]
    new_mean, new_covariance = updated(
        mean[own], covariance[own], innovation[known], noise[known], jacobian
    )
    for index, track in enumerate(own):
        mean[track], covariance[track] = new_mean[index], new_covariance[index]


@compiled(types.void(_TABLE, INTS_1D, FLOATS_2D, FLOATS_3D, types.f8))
def follow_size(extent: Floats, rows: Ints, box: Floats, sizes: Floats, share: float) -> None:
    """
    Let the (t, 2) sizes of tracks, m, follow (n, 4) boxes, px, by a share of the difference.

    ``rows`` tell whose each box is, -1: nobody's; ``sizes`` is the `SizeTable.table`.
    """
    for index, track in enumerate(rows):
        if track != NEW:
            x, y = foot_below(sizes, box[index])
            metre = metre_at(sizes, x, y)
            for axis in range(2):
                measured = box[index, 2 + axis] / metre[axis]
                extent[track, axis] += share * (measured - extent[track, axis])


@compiled(types.void(_TABLE, INTS_1D, FLOATS_2D, types.f8))
def follow_colours(template: Floats, rows: Ints, seen: Floats, share: float) -> None:
    """Let the (t, 48) colours of tracks follow (n, 48) seen ones; ``rows`` as above."""
    for index, track in enumerate(rows):
        if track != NEW:
            template[track] += share * (seen[index] - template[track])
