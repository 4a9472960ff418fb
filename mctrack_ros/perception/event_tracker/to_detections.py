"""Detections of the persons in an image, for fusion and inside the camera; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.blob_split.measurements import OBSERVATIONS, Observations
from mctrack_ros.perception.geometry.person_size import metre_at

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_TABLE = types.f8[:, ::1]


@compiled(
    types.Tuple([types.i8[::1], _TABLE, _TABLE, types.b1[::1], types.f8[::1], types.f8[::1]])(
        OBSERVATIONS, BOOLS_1D, INTS_1D, FLOATS_2D, INTS_1D, types.i8
    )
)
def sighted(
    seen: Observations, confirmed: Booleans, local_id: Ints, mean: Floats, first_ns: Ints,
    stamp_ns: int,
) -> tuple[Ints, Floats, Floats, Booleans, Floats, Floats]:  # fmt: skip
    """Return the columns of `ConfirmedTracks`: the confirmed tracks, as an image shows them."""
    row_of, count = np.full(len(confirmed), -1), 0
    for row in range(len(seen.track)):
        if seen.track[row] >= 0:
            row_of[seen.track[row]] = row
    for track in range(len(confirmed)):
        count += confirmed[track]
    ids, place, box = np.empty(count, np.int64), np.empty((count, 2)), np.zeros((count, 4))
    is_seen, proven = np.zeros(count, np.bool_), np.zeros(count)
    age_s, index = np.empty(count), 0
    for track in range(len(confirmed)):
        if not confirmed[track]:
            continue
        ids[index], row = local_id[track], row_of[track]
        place[index, 0], place[index, 1] = mean[track, 0], mean[track, 1]
        age_s[index] = (stamp_ns - first_ns[track]) * 1e-9
        if row >= 0:
            is_seen[index], proven[index] = True, seen.proven[row]
            for side in range(4):
                box[index, side] = seen.box[row, side]
        index += 1
    return ids, place, box, is_seen, proven, age_s


class ReportedPersons(NamedTuple):
    """Columns of `Detections`, as these are stored."""

    position: NDArray[np.float32]
    box: NDArray[np.float32]
    area: NDArray[np.float32]
    score: NDArray[np.float32]
    extent: NDArray[np.float32]
    template: NDArray[np.float32]
    local_id: NDArray[np.uint32]
    track_id: NDArray[np.uint32]
    truncated: NDArray[np.uint8]


_SINGLES, _SINGLE_TABLE = types.f4[::1], types.f4[:, ::1]
SHOWN = types.NamedTuple(
    [
        _SINGLE_TABLE, _SINGLE_TABLE, _SINGLES, _SINGLES, _SINGLE_TABLE, _SINGLE_TABLE,
        types.u4[::1], types.u4[::1], types.u1[::1],
    ],
    ReportedPersons,
)  # fmt: skip
LEAST_SCORE = 0.1
LEAST_COLOURED = 0.3
"""Least visible share of a body from which its own colours are used; by trial."""


@compiled(
    SHOWN(
        OBSERVATIONS, FLOATS_1D, BOOLS_1D, FLOATS_3D, INTS_1D, INTS_1D, INTS_1D, FLOATS_2D,
        types.i8, types.f8,
    )
)  # fmt: skip
def reported_persons(
    seen: Observations, blob_area: Floats, truncated: Booleans, sizes: Floats, first_ns: Ints,
    local_id: Ints, track_id: Ints, template: Floats, stamp_ns: int, confirm_s: float,
) -> ReportedPersons:  # fmt: skip
    """
    Write one row a person.

    Parameters
    ----------
    seen : Observations
        The persons, every one with a track.
    blob_area, truncated : (m,) arrays
        Foreground of the blobs, px², and which touch the image's edge.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`: who is alone in a whole blob is as large as that.
    first_ns, local_id, track_id, template : (t, ...) arrays
        Of the tracks: when they began, ns, their ids and colours.
    stamp_ns : int
        Time of the image, ns.
    confirm_s : float
        Age at which a track is certain, s.

    """
    count = len(seen.track)
    shown = ReportedPersons(
        np.zeros((count, 3), np.float32),
        np.empty((count, 4), np.float32),
        np.empty(count, np.float32),
        np.empty(count, np.float32),
        np.empty((count, 2), np.float32),
        np.empty((count, template.shape[1]), np.float32),
        np.empty(count, np.uint32),
        np.empty(count, np.uint32),
        np.empty(count, np.uint8),
    )
    for row, track in enumerate(seen.track):
        blob, is_body = seen.blob[row], seen.fitted[row]
        for axis in range(2):
            shown.position[row, axis] = seen.position[row, axis]
        for side in range(4):
            shown.box[row, side] = seen.box[row, side]
        area = seen.visible[row] * seen.box[row, 2] * seen.box[row, 3]
        shown.area[row] = area if is_body else blob_area[blob]
        age = (stamp_ns - first_ns[track]) * 1e-9
        shown.score[row] = min(max(age / confirm_s, LEAST_SCORE), 1.0)
        is_coloured = not is_body or seen.visible[row] >= LEAST_COLOURED
        for bin in range(template.shape[1]):
            own = seen.template[row, bin] if is_coloured else template[track, bin]
            shown.template[row, bin] = own
        metre = metre_at(sizes, seen.foot[row, 0], seen.foot[row, 1])
        is_whole = not is_body and not truncated[blob]
        for axis in range(2):
            size = seen.box[row, 2 + axis] / metre[axis]
            shown.extent[row, axis] = size if is_whole else np.nan
        shown.local_id[row], shown.track_id[row] = local_id[track], track_id[track]
        shown.truncated[row] = truncated[blob]
    return shown
