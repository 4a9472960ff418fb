"""What each camera says of targets, beside what the others say of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.tracking.kalman import inverse

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_TRACKS = 32
"""Number of tracks that are compared at a time."""
REACH_M = 3.0
"""A detection farther from where the others see a target is not taken for it."""
ROOM = 6.0
"""How many variances, the mean of both axes, half the way to the next target must be squared."""


def compare(
    state: Floats, seen: Indices, turn: int, batch: Batch, position: Floats, noise: Floats,
    doubt: Floats,
) -> tuple[Indices, Floats, Floats]:  # fmt: skip
    """
    Compare cameras on some targets that two or more others measured in the same tick.

    What the camera itself says is looked for in its image near where the others see the target,
    whatever its detections were associated with: one that lies far off would not be among them.
    There must be one alone, and no other target that is as near.

    Parameters
    ----------
    state : (n, 4) array
        Of the tracks at the tick; of these the velocities count, and how far they are apart.
    seen : (n, cameras) int array
        Which detection each camera has of each track, -1: none.
    turn : int
        Who comes first; the next ones follow.
    batch : Batch
        The images.
    position, noise : (m, 2), (m, 2, 2) arrays
        Where the cameras themselves say that the detections are, m, and the covariances, m².
    doubt : (cameras,) array
        What is added to the variances of each as a witness, m².

    Returns
    -------
    camera : (k,) int array
        Who is compared, ascending.
    residual : (k, 2) array
        By how much its detection lies off, m.
    covariance : (k, 2, 2) array
        What is to be expected of that by what all say of themselves, and the doubt, m².

    """
    tracks = (turn + np.arange(min(len(state), MOST_TRACKS))) % len(state)
    tracks = tracks[(seen[tracks] >= 0).sum(axis=1) > 1]
    later = batch.seconds[batch.image]
    count, place, spread = _witnessed(state[tracks], seen[tracks], later, position, noise, doubt)
    half = _half_way(tracks, state)
    witnesses = (seen >= 0).sum(axis=1)
    found = [(np.empty(0, np.intp), np.empty((0, 2)), np.empty((0, 2, 2)))]
    for own in np.unique(batch.camera).tolist():
        rows, asked = _latest_image(batch, own), np.flatnonzero(count[:, own] > 1)
        is_other = witnesses > (seen[:, own] >= 0)
        room = half[asked].min(axis=1, initial=REACH_M**2, where=is_other)
        there = position[rows] - later[rows, None] * state[tracks[asked], None, 2:4]
        apart = there - place[asked, own, None]
        near = apart[..., 0] ** 2 + apart[..., 1] ** 2 < room[:, None]
        row = near.argmax(axis=1)
        is_only = (near.sum(axis=1) == 1) & ~batch.is_overlapped[rows][row]
        covariance = spread[asked, own] + noise[rows[row]]
        is_clear = ROOM * covariance.trace(axis1=1, axis2=2) / 2 <= room
        used = np.flatnonzero(is_only & is_clear)
        found.append((np.full(len(used), own), apart[used, row[used]], covariance[used]))
    camera, residual, covariance = (np.concatenate(each) for each in zip(*found))
    return camera, residual, covariance


def _witnessed(
    state: Floats, seen: Indices, later: Floats, position: Floats, noise: Floats, doubt: Floats
) -> tuple[Indices, Floats, Floats]:
    """
    Join what all cameras but one see of tracks (n,), by inverse covariances.

    Returns
    -------
    count : (n, cameras) int array
        How many others see it.
    place, covariance : (n, cameras, 2), (n, cameras, 2, 2) arrays
        Where it is at the tick, m, and how surely, m²; 0 where nobody does.

    """
    is_seen = seen >= 0
    there = position[seen] - later[seen][..., None] * state[:, None, 2:4]
    weight = inverse(noise[seen] + doubt[:, None, None] * np.eye(2)) * is_seen[..., None, None]
    others = 1.0 - np.eye(len(doubt))
    information = np.einsum('oc,ncij->noij', others, weight)
    pull = np.einsum('oc,ncij,ncj->noi', others, weight, there)
    count = is_seen.sum(axis=1, keepdims=True) - is_seen
    covariance = np.where(count[..., None, None] > 0, inverse(information), 0.0)
    return count, np.einsum('noij,noj->noi', covariance, pull), covariance


def _half_way(tracks: Indices, state: Floats) -> Floats:
    """Return the squares, (k, n) m², of half the way from each of these tracks to all others."""
    half = cdist(state[tracks, :2], state[:, :2], 'sqeuclidean') / 4
    half[np.arange(len(tracks)), tracks] = np.inf
    return np.asarray(half)


def _latest_image(batch: Batch, camera: int) -> Indices:
    """Return the rows (k,) of a camera's last image of the tick."""
    rows = np.flatnonzero(batch.camera == camera)
    return np.asarray(rows[batch.image[rows] == batch.image[rows[-1]]])
