"""What each camera says of targets, beside what the others say of them."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_2D,
    FLOATS_1D,
    FLOATS_3D,
    INTS_1D,
    INTS_2D,
    compiled,
)
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
    if not len(tracks):
        return np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2, 2))
    later = batch.seconds[batch.image]
    count, place, spread = _witnessed(state[tracks], seen[tracks], later, position, noise, doubt)
    room, row = np.full(count.shape, REACH_M**2), np.full(count.shape, -1)
    images = _latest_images(batch, len(doubt))
    _alone(tracks, count, place, state, seen, *images, later, position, room, row)
    own, track = (row >= 0).T.nonzero()
    row = row[track, own]
    covariance = spread[track, own] + noise[row]
    is_clear = ROOM * covariance.trace(axis1=1, axis2=2) / 2 <= room[track, own]
    is_clear &= ~batch.is_overlapped[row]
    residual = position[row] - later[row, None] * state[tracks[track], 2:] - place[track, own]
    return own[is_clear], residual[is_clear], covariance[is_clear]


@compiled(
    types.void(
        INTS_1D, INTS_2D, FLOATS_3D, COLUMN_2D, INTS_2D, INTS_1D, INTS_1D, FLOATS_1D, COLUMN_2D,
        types.f8[:, ::1], types.i8[:, ::1],
    )
)  # fmt: skip
def _alone(
    tracks: Indices, count: Indices, place: Floats, state: Floats, seen: Indices, begin: Indices,
    end: Indices, later: Floats, position: Floats, room: Floats, row: Indices,
) -> None:  # fmt: skip
    """
    Find the only detection of each camera near where two or more others see a target.

    `room` and `row`, (n, cameras), take the square of half the way to the next target that another
    camera sees, m², and the detection so near; -1: none, or not alone.
    """
    for index in range(len(tracks)):
        track = tracks[index]
        for own in range(count.shape[1]):
            if count[index, own] < 2:
                continue
            for other in range(len(state)):
                x, y = state[other, 0] - state[track, 0], state[other, 1] - state[track, 1]
                squared = (x * x + y * y) / 4.0
                if other != track and squared < room[index, own]:
                    for eye in range(seen.shape[1]):
                        if eye != own and seen[other, eye] >= 0:
                            room[index, own] = squared
                            break
            near = 0
            for one in range(begin[own], end[own]):
                x = position[one, 0] - later[one] * state[track, 2] - place[index, own, 0]
                y = position[one, 1] - later[one] * state[track, 3] - place[index, own, 1]
                if x * x + y * y < room[index, own]:
                    near, row[index, own] = near + 1, one
            if near != 1:
                row[index, own] = -1


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
    information = (others @ weight.reshape(*is_seen.shape, 4)).reshape(weight.shape)
    pull = others @ (weight @ there[..., None])[..., 0]
    count = is_seen.sum(axis=1, keepdims=True) - is_seen
    covariance = np.where(count[..., None, None] > 0, inverse(information), 0.0)
    return count, (covariance @ pull[..., None])[..., 0], covariance


def _latest_images(batch: Batch, cameras: int) -> tuple[Indices, Indices]:
    """Return the first row of each camera's last image, (cameras,), and the one after it."""
    image = np.full(cameras, -1)
    image[batch.camera] = batch.image  # ascending: the last one stays
    return batch.image.searchsorted(image), batch.image.searchsorted(image, 'right')
