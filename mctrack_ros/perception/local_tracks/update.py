"""What tracks learn from the persons seen in an image; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.blob_split.measurements import (
    LEAST_OWN_SHARE,
    LEAST_VISIBLE,
    OBSERVATIONS,
    Observations,
)
from mctrack_ros.perception.blob_split.single_blobs import NEW
from mctrack_ros.perception.geometry.person_size import metre_at
from mctrack_ros.tracking.kalman import updated

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_TIMES = types.i8[::1]
_TABLE = types.f8[:, ::1]


class LearningRates(NamedTuple):
    """
    How fast it is learned.

    Attributes
    ----------
    size, colours : float
        Share of the difference by which sizes and colours follow those seen.

    """

    size: float
    colours: float


@compiled(
    types.i8[::1](
        OBSERVATIONS, BOOLS_1D, types.i8, FLOATS_3D,
        types.NamedUniTuple(types.f8, 2, LearningRates), _TIMES, _TIMES, _TABLE, _TABLE,
    )
)  # fmt: skip
def learn(
    seen: Observations, truncated: Booleans, stamp_ns: int, sizes: Floats, pace: LearningRates,
    seen_ns: Ints, clear_ns: Ints, extent: Floats, template: Floats,
) -> Ints:  # fmt: skip
    """
    Let tracks follow how large and of which colours those are who are alone in a blob.

    Parameters
    ----------
    seen : Observations
        The persons.
    truncated : (m,) bool array
        Which blobs touch the image's edge: they have no size.
    stamp_ns : int
        Time of the image, ns.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    pace : LearningRates
        How fast it is learned.
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
        if seen.own_share[row] >= LEAST_OWN_SHARE:
            clear_ns[track] = stamp_ns
        if not seen.fitted[row] or seen.visible[row] >= LEAST_VISIBLE:
            measured[row] = track
        if seen.fitted[row]:
            continue
        for bin in range(template.shape[1]):
            template[track, bin] += pace.colours * (seen.template[row, bin] - template[track, bin])
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
    one, spread = np.empty((1, 4)), np.empty((1, 4, 4))
    innovation, error, jacobian = np.empty((1, 2)), np.empty((1, 2, 2)), np.zeros((1, 2, 4))
    for index, track in enumerate(rows):
        if track == NEW:
            continue
        for i in range(2):
            innovation[0, i] = foot[index, i] - expected[track, i]
            for j in range(2):
                error[0, i, j], jacobian[0, i, j] = noise[index, i, j], slope[track, i, j]
        if not (np.isfinite(innovation[0, 0]) and np.isfinite(innovation[0, 1])):
            continue
        for i in range(4):
            one[0, i] = mean[track, i]
            for j in range(4):
                spread[0, i, j] = covariance[track, i, j]
        new_mean, new_covariance = updated(one, spread, innovation, error, jacobian)
        for i in range(4):
            mean[track, i] = new_mean[0, i]
            for j in range(4):
                covariance[track, i, j] = new_covariance[0, i, j]
