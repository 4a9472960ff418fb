"""Detections that stand for several targets: groups of which not everybody is seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import MEMBERS, Detections
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

Ints = NDArray[np.int64]
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
    is_shown = np.isin(in_view.local_id, shown.local_id)
    is_hidden = (part >= 0) & (in_view.track_id > 0) & ~is_shown
    wanted = set(part[is_hidden].tolist()) & set(part[is_shown].tolist())
    groups = [np.flatnonzero(part == one) for one in dict.fromkeys(part.tolist()) if one in wanted]
    if not groups:
        return NONE
    position, covariance = np.zeros((len(groups), 3)), np.empty((len(groups), 2, 2))
    box, members = np.empty((len(groups), 4)), np.zeros((len(groups), MEMBERS), np.uint32)
    for index, rows in enumerate(groups):
        seen = in_view.position[rows[is_shown[rows]]]
        position[index, :2] = middle = seen.mean(axis=0)
        apart = seen - middle
        covariance[index] = apart.T @ apart / len(seen) + SPREAD_M**2 * np.eye(2)
        low, size = in_view.box[rows, :2], in_view.box[rows, 2:]
        box[index, :2] = corner = low.min(axis=0)
        box[index, 2:] = (low + size).max(axis=0) - corner
        named = in_view.track_id[rows]
        named = named[named > 0][:MEMBERS]
        members[index, : len(named)] = named
    return Detections.build(
        shown.stamp_ns,
        position=position,
        covariance=covariance,
        box=box,
        members=members,
        member_count=[len(rows) for rows in groups],
    )
