"""Detections that stand for several targets: groups of which not everybody is seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import MEMBERS, Detections
from mctrack_ros.perception.company import Company

Ints = NDArray[np.int64]
NONE = Detections.build(0)
SPREAD_M = 1.0
"""Standard deviation of a hidden member about the middle of those who are seen, m."""


def merged_detections(company: Company, part: Ints, shown: Detections) -> Detections:
    """
    Return one row for each group with members who are not shown (Definition 6, R5).

    Parameters
    ----------
    company : Company
        Everybody in view.
    part : (n,) int64 array
        The part of the foreground each is in (see `contacts`); -1: not seen.
    shown : Detections
        What is told of single persons.

    """
    is_shown = (company.local_id[:, None] == shown.local_id).any(axis=1)
    groups = []
    for number in set(part[~is_shown & (company.track_id > 0) & (part >= 0)].tolist()):
        rows = np.flatnonzero(part == number)
        if is_shown[rows].any():
            groups.append(rows)
    if not groups:
        return NONE
    groups.sort(key=lambda rows: int(rows[0]))
    members = np.zeros((len(groups), MEMBERS), np.uint32)
    for row, rows in enumerate(groups):
        named = company.track_id[rows][company.track_id[rows] > 0][:MEMBERS]
        members[row, : len(named)] = named
    seen = [rows[is_shown[rows]] for rows in groups]
    return Detections.build(
        shown.stamp_ns,
        position=[[*company.position[rows].mean(axis=0), 0.0] for rows in seen],
        covariance=[_spread(company.position[rows]) for rows in seen],
        box=[_around(company.box[rows]) for rows in seen],
        members=members,
        member_count=[len(rows) for rows in groups],
    )


def _spread(position: NDArray[np.float64]) -> NDArray[np.float64]:
    off = position - position.mean(axis=0)
    return np.asarray(off.T @ off / len(off) + SPREAD_M**2 * np.eye(2))


def _around(box: NDArray[np.float64]) -> NDArray[np.float64]:
    low = box[:, :2].min(axis=0)
    return np.concatenate([low, (box[:, :2] + box[:, 2:]).max(axis=0) - low])
