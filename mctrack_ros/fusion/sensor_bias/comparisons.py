"""What each camera says of targets, beside what the others say of them."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    COLUMN_2D,
    COLUMN_3D,
    COLUMN_STAMPS,
    FLOATS_1D,
    INTS_2D,
    compiled,
    inner,
)
from mctrack_ros.fusion.measurements.batch import Batch

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
        Who is compared.
    residual : (k, 2) array
        By how much its detection lies off, m.
    covariance : (k, 2, 2) array
        What is to be expected of that by what all say of themselves, and the doubt, m².

    """
    return _compared(
        state, seen, turn, batch.seconds, batch.image, batch.camera, batch.is_overlapped,
        position, noise, doubt,
    )  # fmt: skip


@inner
def _witnessed(
    own: int, rows: Indices, state: Floats, later: Floats, position: Floats, noise: Floats,
    doubt: Floats,
) -> tuple[int, Floats, Floats]:  # fmt: skip
    """Return how many cameras beside one see a track, where at the tick, and how surely."""
    reported, xx, xy, yy, x, y = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for other in range(len(rows)):
        row = rows[other]
        if row >= 0 and other != own:
            a, b, c = noise[row, 0, 0] + doubt[other], noise[row, 0, 1], noise[row, 1, 1]
            c += doubt[other]
            scale = 1.0 / (a * c - b * b)
            a, b, c = c * scale, -b * scale, a * scale
            u = position[row, 0] - later[row] * state[2]
            v = position[row, 1] - later[row] * state[3]
            reported, xx, xy, yy = reported + 1, xx + a, xy + b, yy + c
            x, y = x + a * u + b * v, y + b * u + c * v
    covariance = np.zeros((2, 2))
    if reported:
        scale = 1.0 / (xx * yy - xy * xy)
        covariance[0, 0], covariance[1, 1] = yy * scale, xx * scale
        covariance[0, 1] = covariance[1, 0] = -xy * scale
    x, y = covariance[0, 0] * x + covariance[0, 1] * y, covariance[1, 0] * x + covariance[1, 1] * y
    return reported, np.array([x, y]), covariance


@inner
def _room(own: int, track: int, state: Floats, seen: Indices) -> float:
    """Return the square of half the way to the next target that another camera sees, m²."""
    room = REACH_M * REACH_M
    for other in range(len(state)):
        x, y = state[other, 0] - state[track, 0], state[other, 1] - state[track, 1]
        squared = (x * x + y * y) / 4
        if other != track and squared < room:
            for eye in range(seen.shape[1]):
                if eye != own and seen[other, eye] >= 0:
                    room = squared
                    break
    return room


@inner
def _only(
    first: int, last: int, place: Floats, room: float, state: Floats, later: Floats,
    position: Floats, is_overlapped: NDArray[np.bool_],
) -> int:  # fmt: skip
    """Return the only row of an image so near to a place, -1: none, or not alone."""
    near = -1
    for row in range(first, last):
        x = position[row, 0] - later[row] * state[2] - place[0]
        y = position[row, 1] - later[row] * state[3] - place[1]
        if x * x + y * y < room:
            if near >= 0 or is_overlapped[row]:
                return -1
            near = row
    return near


@inner
def _images(image: Indices, camera: Indices, cameras: int) -> Indices:
    """Return the (cameras, 2) first row and the one after the last of each one's last image."""
    bounds = np.zeros((cameras, 2), np.int64)
    for row in range(len(image)):
        if row == 0 or image[row] != image[row - 1]:
            bounds[camera[row], 0] = row
        bounds[camera[row], 1] = row + 1
    return bounds


@compiled(
    types.Tuple([types.i8[::1], types.f8[:, ::1], types.f8[:, :, ::1]])(
        COLUMN_2D, INTS_2D, types.i8, FLOATS_1D, COLUMN_STAMPS, COLUMN_STAMPS, BOOLS_1D, COLUMN_2D,
        COLUMN_3D, FLOATS_1D,
    )
)  # fmt: skip
def _compared(
    state: Floats, seen: Indices, turn: int, seconds: Floats, image: Indices, camera: Indices,
    is_overlapped: NDArray[np.bool_], position: Floats, noise: Floats, doubt: Floats,
) -> tuple[Indices, Floats, Floats]:  # fmt: skip
    tracks, cameras = seen.shape
    most, count = min(tracks, MOST_TRACKS), 0
    who = np.empty(most * cameras, np.int64)
    residual, covariance = np.empty((len(who), 2)), np.empty((len(who), 2, 2))
    bounds, later = _images(image, camera, cameras), seconds[image]
    for step in range(most):
        track = (turn + step) % tracks
        for own in range(cameras):
            reported, place, spread = _witnessed(
                own, seen[track], state[track], later, position, noise, doubt
            )
            if reported < 2:
                continue
            room = _room(own, track, state, seen)
            row = _only(
                bounds[own, 0], bounds[own, 1], place, room, state[track], later, position,
                is_overlapped,
            )  # fmt: skip
            if row < 0:
                continue
            spread += noise[row]
            if ROOM * (spread[0, 0] + spread[1, 1]) / 2 <= room:
                who[count], covariance[count] = own, spread
                residual[count] = position[row] - later[row] * state[track, 2:4] - place
                count += 1
    return who[:count], residual[:count], covariance[:count]
