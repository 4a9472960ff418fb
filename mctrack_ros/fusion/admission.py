"""Which detections can be used at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled
from mctrack_ros.interfaces import Detections

LARGEST_VARIANCE = 1e6
"""A detection less certain than this says nothing, m²."""
LARGEST_DISTANCE = 1e6
"""Nobody is farther than this from the origin, m."""
MOST_DETECTIONS = 1000
"""More than this in one picture are not detections: those of the highest score are used."""


def usable_rows(detections: Detections) -> NDArray[np.bool_]:
    """
    Tell which detections of one picture, (n,), have a sound position and covariance.

    A covariance is sound if it is finite, symmetric enough to be positive definite, and not
    larger than a square kilometre. Of a flood only `MOST_DETECTIONS` are used.
    """
    usable = _is_sound(detections)
    if len(usable) > MOST_DETECTIONS:
        rows = np.flatnonzero(usable)
        order = np.argsort(-detections.score[rows], kind='stable')
        usable[rows[order[MOST_DETECTIONS:]]] = False
    return usable


def usable_of_all(
    stamp_ns: int, pictures: Sequence[Detections]
) -> tuple[Detections, NDArray[np.intp]]:
    """
    Join the usable detections of several pictures.

    Returns
    -------
    detections : Detections
        Those of one picture after the other, m rows, under that stamp, ns.
    picture : (m,) int array
        Which picture each is of.

    """
    pictures = [
        each.select(usable_rows(each)) if len(each) > MOST_DETECTIONS else each
        for each in pictures
    ]
    detections = Detections.joined(stamp_ns, pictures)
    picture = np.arange(len(pictures)).repeat([len(each) for each in pictures])
    usable = _is_sound(detections)
    if usable.all():
        return detections, picture
    return detections.select(usable), picture[usable]


def vacant_of_all(
    pictures: Sequence[Detections],
    cameras: Sequence[int],
    track_id: NDArray[np.uint32],
    count: int,
) -> NDArray[np.bool_]:
    """Return which of so many cameras, (n, count), say that a track is not where expected."""
    vacant = np.zeros((len(track_id), count), np.bool_)
    for picture, camera in zip(pictures, cameras):
        rows = picture.is_vacant
        if rows.any():
            vacant[:, camera] |= np.isin(track_id, picture.track_id[rows])
    return vacant


def _is_sound(detections: Detections) -> NDArray[np.bool_]:
    return _usable(
        np.ascontiguousarray(detections.covariance), np.ascontiguousarray(detections.position)
    )


@compiled(
    types.b1[::1](
        types.Array(types.f4, 3, 'C', readonly=True), types.Array(types.f4, 2, 'C', readonly=True)
    )
)
def _usable(covariance: NDArray[np.float32], position: NDArray[np.float32]) -> NDArray[np.bool_]:
    usable = np.empty(len(position), np.bool_)
    for row in range(len(position)):
        xx, yy = np.float64(covariance[row, 0, 0]), np.float64(covariance[row, 1, 1])
        xy = (np.float64(covariance[row, 0, 1]) + np.float64(covariance[row, 1, 0])) / 2
        sound = xx > 0 and yy > 0 and xx * yy > xy * xy
        sound = sound and xx < LARGEST_VARIANCE and yy < LARGEST_VARIANCE
        known = abs(position[row, 0]) < LARGEST_DISTANCE
        known = known and abs(position[row, 1]) < LARGEST_DISTANCE
        usable[row] = sound and known
    return usable
