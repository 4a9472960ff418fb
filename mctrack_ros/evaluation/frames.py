"""Truth and tracks side by side, frame by frame, with the distances between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.evaluation.trajectories import Trajectories

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """
    One instant.

    Attributes
    ----------
    number : int
        The frame.
    truth : (n,) int array
        Indices of the true ids, from 0.
    tracks : (m,) int array
        Indices of the track ids, from 0.
    distance : (n, m) float array
        Between them: metres, or 1 - IoU.

    """

    number: int
    truth: Indices
    tracks: Indices
    distance: Floats


def ground_distance(truth: Floats, tracks: Floats) -> Floats:
    """Return the Euclidean distances of (n, 2) and (m, 2) positions, (n, m), m."""
    return np.asarray(np.linalg.norm(truth[:, None] - tracks[None], axis=2), np.float64)


def box_distance(truth: Floats, tracks: Floats) -> Floats:
    """Return 1 - intersection over union of (n, 4) and (m, 4) boxes, (n, m)."""
    near = np.maximum(truth[:, None, :2], tracks[None, :, :2])
    far_truth, far_tracks = truth[:, :2] + truth[:, 2:], tracks[:, :2] + tracks[:, 2:]
    far = np.minimum(far_truth[:, None], far_tracks[None])
    both = np.clip(far - near, 0.0, None).prod(axis=2)
    either = truth[:, 2:].prod(axis=1)[:, None] + tracks[:, 2:].prod(axis=1)[None] - both
    overlap: Floats = np.divide(both, either, out=np.zeros_like(both), where=either > 0)
    return 1.0 - overlap


def matched(distance: Floats, gate: float) -> tuple[Indices, Indices]:
    """
    Match as many pairs within the gate as possible, at the least total distance.

    Parameters
    ----------
    distance : (n, m) array
        Between truth and tracks.
    gate : float
        Largest distance of a pair.

    Returns
    -------
    rows, columns : (k,) int arrays
        The pairs.

    """
    beyond = (gate + 1.0) * (min(distance.shape) + 1.0)
    rows, columns = linear_sum_assignment(np.where(distance <= gate, distance, beyond))
    kept = distance[rows, columns] <= gate
    return rows[kept], columns[kept]


def frames_of(
    truth: Trajectories,
    tracks: Trajectories,
    geometry: str,
    distance: Callable[[Floats, Floats], Floats],
    gate: float,
) -> list[Frame]:
    """
    Lay truth and tracks side by side.

    Truth to be ignored takes part in one matching of its frame; then it is dropped together with
    the tracks matched to it, as the MOTChallenge benchmark does (Milan et al. 2016, section 4.1).

    Parameters
    ----------
    truth, tracks : Trajectories
        In any order.
    geometry : str
        ``position`` or ``box``.
    distance : callable
        Of (n, d) and (m, d) values, (n, m).
    gate : float
        Largest distance of a match.

    Returns
    -------
    list of Frame
        Every frame that has truth or tracks, ascending.

    """
    truth_index = np.unique(truth.id, return_inverse=True)[1]
    track_index = np.unique(tracks.id, return_inverse=True)[1]
    truth_rows, track_rows = _rows_by_frame(truth), _rows_by_frame(tracks)
    nothing = np.empty(0, np.intp)
    frames = []
    for number in sorted(truth_rows.keys() | track_rows.keys()):
        mine = truth_rows.get(number, nothing)
        theirs = track_rows.get(number, nothing)
        apart = distance(getattr(truth, geometry)[mine], getattr(tracks, geometry)[theirs])
        counts, stays = _without_ignored(truth.ignore[mine], apart, gate)
        frames.append(
            Frame(
                number,
                truth_index[mine[counts]],
                track_index[theirs[stays]],
                apart[np.ix_(counts, stays)],
            )
        )
    return frames


def _rows_by_frame(rows: Trajectories) -> dict[int, Indices]:
    order = np.lexsort((rows.id, rows.frame))
    numbers, starts = np.unique(rows.frame[order], return_index=True)
    return dict(zip(numbers.tolist(), np.split(order, starts[1:])))


def _without_ignored(
    ignore: NDArray[np.bool_], distance: Floats, gate: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    stays = np.ones(distance.shape[1], np.bool_)
    if ignore.any():
        rows, columns = matched(distance, gate)
        stays[columns[ignore[rows]]] = False
    return ~ignore, stays
