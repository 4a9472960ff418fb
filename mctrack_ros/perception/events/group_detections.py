"""Detections that stand for several targets: groups of which not everybody is seen."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, INTS_1D, compiled
from mctrack_ros.interfaces import MEMBERS, Detections
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
NONE = Detections.build(0)
SPREAD_M = 1.0
"""Standard deviation of a hidden member about the middle of those who are seen, m."""


def merged_detections(in_view: PersonsInView, part: Ints, shown: Detections) -> Detections:
    """
    Return one row for each group with members who are not shown (Definition 6, R5).

    Parameters
    ----------
    in_view : PersonsInView
        Everybody in view.
    part : (n,) int64 array
        The part of the foreground each is in (see `contacts`); -1: not seen.
    shown : Detections
        What is told of single persons.

    """
    position, covariance, box, members, count = _gathered(
        part,
        in_view.local_id,
        shown.local_id.astype(np.int64),
        in_view.track_id,
        in_view.position,
        in_view.box,
    )
    if len(count) == 0:
        return NONE
    return Detections.build(
        shown.stamp_ns,
        position=position,
        covariance=covariance,
        box=box,
        members=members,
        member_count=count,
    )


@compiled(
    types.Tuple(
        [types.f8[:, ::1], types.f8[:, :, ::1], types.f8[:, ::1], types.u4[:, ::1], types.i8[::1]]
    )(INTS_1D, INTS_1D, INTS_1D, INTS_1D, FLOATS_2D, FLOATS_2D)
)
def _gathered(
    part: Ints, local_id: Ints, shown: Ints, track_id: Ints, position: Floats, box: Floats
) -> tuple[Floats, Floats, Floats, NDArray[np.uint32], Ints]:
    """Return place, covariance, box, members and their number of each group that hides some."""
    most = len(part)
    is_shown = np.array([(shown == one).any() for one in local_id], np.bool_)
    place, spread = np.zeros((most, 3)), np.zeros((most, 2, 2))
    around, members = np.empty((most, 4)), np.zeros((most, MEMBERS), np.uint32)
    count = np.zeros(most, np.int64)
    done = 0
    for first in range(most):
        if part[first] < 0 or (part[:first] == part[first]).any():
            continue
        rows = np.flatnonzero(part == part[first])
        seen = rows[is_shown[rows]]
        named = track_id[rows][track_id[rows] > 0]
        if len(seen) == 0 or not (~is_shown[rows] & (track_id[rows] > 0)).any():
            continue
        for axis in range(2):
            place[done, axis] = position[seen, axis].mean()
            around[done, axis] = box[rows, axis].min()
            around[done, 2 + axis] = (box[rows, axis] + box[rows, 2 + axis]).max()
            around[done, 2 + axis] -= around[done, axis]
        off_x, off_y = position[seen, 0] - place[done, 0], position[seen, 1] - place[done, 1]
        spread[done, 0, 0] = (off_x * off_x).mean() + SPREAD_M**2
        spread[done, 1, 1] = (off_y * off_y).mean() + SPREAD_M**2
        spread[done, 0, 1] = spread[done, 1, 0] = (off_x * off_y).mean()
        members[done, : min(len(named), MEMBERS)] = named[:MEMBERS]
        count[done] = len(rows)
        done += 1
    return place[:done], spread[:done], around[:done], members[:done], count[:done]
