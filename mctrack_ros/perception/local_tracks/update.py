"""What tracks learn from the persons seen in an image; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.blob_split.measurements import OBSERVATIONS, Observations
from mctrack_ros.perception.blob_split.single_blobs import NEW
from mctrack_ros.perception.geometry.person_size import metre_at
from mctrack_ros.tracking.kalman import updated

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_TIMES = types.i8[::1]
_TABLE = types.f8[:, ::1]


class Pace(NamedTuple):
    """
    What is learned of whom, and how fast.

    Attributes
    ----------
    size, colours : float
        Share of the difference by which sizes and colours follow those seen.
    least_visible : float
        Share of a body that must be seen to measure it.
    least_proven : float
        Share of a body that must explain what older tracks do not, to be sure of it.

    """

    size: float
    colours: float
    least_visible: float
    least_proven: float


@compiled(
    types.i8[::1](
        OBSERVATIONS, BOOLS_1D, types.i8, FLOATS_3D, types.NamedUniTuple(types.f8, 4, Pace),
        _TIMES, _TIMES, _TABLE, _TABLE,
    )
)  # fmt: skip
def learn(
    seen: Observations, truncated: Booleans, stamp_ns: int, sizes: Floats, pace: Pace,
    seen_ns: Ints, clear_ns: Ints, extent: Floats, template: Floats,
) -> Ints:  # fmt: skip
    """
    Let tracks follow how large and of which colours those are who are alone in a blob.

    Parameters
    ----------
    seen : Observations
        The persons.
    truncated : (m,) bool array
        Which blobs touch the image's edge: they tell no size.
    stamp_ns : int
        Time of the image, ns.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    pace : Pace
        What is learned of whom, and how fast.
    seen_ns, clear_ns : (t,) int64 arrays
        Last time that each track was seen, and that it was to be sure, ns; changed in place.
    extent, template : (t, 2) and (t, 48) arrays
        Sizes, m, and colours; changed in place.

    Returns
    -------
    (n,) int64 array
        Row of the track that each person's foot point corrects; -1: none.

    """
    measured = np.full(len(seen.track), NEW)
    for row, track in enumerate(seen.track):
        if track == NEW:
            continue
        seen_ns[track] = stamp_ns
        if seen.proven[row] >= pace.least_proven:
            clear_ns[track] = stamp_ns
        if not seen.fitted[row] or seen.visible[row] >= pace.least_visible:
            measured[row] = track
        if seen.fitted[row]:
            continue
        template[track] += pace.colours * (seen.template[row] - template[track])
        if not truncated[seen.blob[row]]:
            metre = metre_at(sizes, seen.foot[row, 0], seen.foot[row, 1])
            for axis in range(2):
                size = seen.box[row, 2 + axis] / metre[axis]
                extent[track, axis] += pace.size * (size - extent[track, axis])
    return measured


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
