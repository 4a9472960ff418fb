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
        Detections of single persons.

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
    is_shown, is_first = np.zeros(most, np.bool_), np.ones(most, np.bool_)
    for row in range(most):
        for one in range(len(shown)):
            is_shown[row] |= shown[one] == local_id[row]
        for before in range(row):
            is_first[row] &= part[before] != part[row]
    place, spread = np.zeros((most, 3)), np.zeros((most, 2, 2))
    around, members = np.empty((most, 4)), np.zeros((most, MEMBERS), np.uint32)
    count = np.zeros(most, np.int64)
    done = 0
    for first in range(most):
        if part[first] < 0 or not is_first[first]:
            continue
        own, seen, named, is_hiding = 0, 0, 0, False
        x = y = 0.0
        left = top = np.inf
        right = bottom = -np.inf
        for row in range(first, most):
            if part[row] != part[first]:
                continue
            own += 1
            left, top = min(left, box[row, 0]), min(top, box[row, 1])
            right = max(right, box[row, 0] + box[row, 2])
            bottom = max(bottom, box[row, 1] + box[row, 3])
            if is_shown[row]:
                seen += 1
                x += position[row, 0]
                y += position[row, 1]
            is_hiding |= track_id[row] > 0 and not is_shown[row]
        if seen == 0 or not is_hiding:
            continue
        x, y = x / seen, y / seen
        xx = xy = yy = 0.0
        for row in range(first, most):
            if part[row] != part[first]:
                continue
            if is_shown[row]:
                off_x, off_y = position[row, 0] - x, position[row, 1] - y
                xx += off_x * off_x
                xy += off_x * off_y
                yy += off_y * off_y
            if track_id[row] > 0 and named < MEMBERS:
                members[done, named] = track_id[row]
                named += 1
        place[done, 0], place[done, 1] = x, y
        spread[done, 0, 0], spread[done, 1, 1] = xx / seen + SPREAD_M**2, yy / seen + SPREAD_M**2
        spread[done, 0, 1] = spread[done, 1, 0] = xy / seen
        around[done, 0], around[done, 1] = left, top
        around[done, 2], around[done, 3] = right - left, bottom - top
        count[done] = own
        done += 1
    return place[:done], spread[:done], around[:done], members[:done], count[:done]
