"""Global ids for local tracks, learned from the fusion node's feedback."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.compiled import FLOATS_2D, INTS_1D, compiled
from mctrack_ros.interfaces import Feedback
from mctrack_ros.tracking.kalman import inverse

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
_FOUND = types.UniTuple(types.b1[::1], 2)
TOO_FAR = 1e6


LEARN_GATE = 9.0
"""Greatest squared Mahalanobis distance at which an id is learned: .99 of chi-square of two."""
LEARN_M = 1.5
"""Greatest distance at which an id is learned; by trial on simulated matches."""
KEEP_M = 3.0
"""Distance from the target at which its id is given up: twice as far."""


class Identified(Protocol):
    """
    A camera's own tracks, of any tracker, as parallel arrays.

    ``local_id`` (n,); ``track_id`` (n,), global, 0: none; ``mean`` (n, 4), x, y (m), vx, vy (m/s)
    on the ground; ``covariance`` (n, 4, 4); ``confirmed`` (n,) bool.
    """

    @property
    def local_id(self) -> Ints: ...  # noqa: D102
    @property
    def track_id(self) -> Ints: ...  # noqa: D102
    @property
    def mean(self) -> Floats: ...  # noqa: D102
    @property
    def covariance(self) -> Floats: ...  # noqa: D102
    @property
    def confirmed(self) -> NDArray[np.bool_]: ...  # noqa: D102


def learn_identities(tracks: Identified, feedback: Feedback, stamp_ns: int) -> None:
    """
    Give confirmed tracks the global ids of the feedback targets that they match, one to one.

    A track keeps its id while the target is known and near; a correction renames it.

    Parameters
    ----------
    tracks : Identified
        At the image's time; ``track_id`` is changed.
    feedback : Feedback
        Older than the image by the design's delay.
    stamp_ns : int
        The image's time, ns.

    """
    _rename_corrected(tracks, feedback)
    known_id = feedback.track_id.astype(np.int64)
    place, seconds = feedback.places(stamp_ns), (stamp_ns - feedback.stamp_ns) * 1e-9
    near, held = _held(tracks.track_id, tracks.mean, known_id, place, KEEP_M)
    tracks.track_id[~near] = 0
    seeking, offered = np.flatnonzero(tracks.confirmed & ~near), np.flatnonzero(~held)
    difference = tracks.mean[seeking, None, :2] - place[None, offered]
    spread = tracks.covariance[seeking], feedback.covariance[offered]
    row, column = _assigned(difference, *spread, seconds)
    tracks.track_id[seeking[row]] = known_id[offered[column]]


def _assigned(
    difference: Floats, own: Floats, other: NDArray[np.float32], seconds: float
) -> tuple[Ints, Ints]:
    """Return the rows (k,) of tracks and (k,) of targets, (t, n, 2) m apart, that are one."""
    usable = np.hypot(difference[..., 0], difference[..., 1]) <= LEARN_M
    if not usable.any():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    cost = _costs(own, other, difference, seconds)
    usable &= (cost >= 0.0) & (cost <= LEARN_GATE)
    row, column = linear_sum_assignment(np.where(usable, cost, TOO_FAR))
    fits = usable[row, column]
    return row[fits], column[fits]


@compiled(_FOUND(INTS_1D, FLOATS_2D, INTS_1D, FLOATS_2D, types.f8))
def _held(
    track_id: Ints, mean: Floats, known_id: Ints, place: Floats, farthest_m: float
) -> tuple[Booleans, Booleans]:
    """Tell which tracks are near the targets whose ids they have, and which ids these are."""
    near, held = np.zeros(len(track_id), np.bool_), np.zeros(len(known_id), np.bool_)
    for track in range(len(track_id)):
        for target in range(len(known_id)):
            if track_id[track] == known_id[target]:
                across = mean[track, 0] - place[target, 0]
                down = mean[track, 1] - place[target, 1]
                if np.hypot(across, down) <= farthest_m:
                    near[track] = held[target] = True
    return near, held


def _rename_corrected(tracks: Identified, feedback: Feedback) -> None:
    """Exchange ids that the fusion node has corrected, all at once."""
    renamed = feedback.corrections()
    if renamed:
        tracks.track_id[:] = [renamed.get(one, one) for one in tracks.track_id.tolist()]


def _costs(
    track: Floats, target: NDArray[np.floating], difference: Floats, seconds: float
) -> Floats:
    """Return (n, m) squared Mahalanobis distances of tracks and targets, by covariance, in m."""
    motion = np.array([[1, 0, seconds, 0], [0, 1, 0, seconds]])
    moved = motion @ target.astype(np.float64) @ motion.T
    spread = track[:, None, :2, :2] + moved[None]
    solved = (inverse(spread) @ difference[..., None])[..., 0]
    cost: Floats = (difference * solved).sum(axis=-1)
    return cost
