"""Which detections can be used at all."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

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
ALWAYS_USED = (
    'position', 'covariance', 'box', 'extent', 'local_id', 'track_id', 'member_count', 'class_id',
)  # fmt: skip
"""Columns that are put together at once."""


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


class Admitted:
    """
    The usable detections of several pictures, one after the other, m rows.

    Their columns are as those of `Detections`; those that are not `ALWAYS_USED` are put together
    when they are first asked for.

    Parameters
    ----------
    pictures : sequence of Detections
        One each.

    Attributes
    ----------
    picture : (m,) int array
        Which picture each is of.
    is_described : (m,) bool array
        Which rows have an appearance template; the templates stay apart.
    vacant_id : (v,) uint32 array
        Targets of which pictures say that they are not where they are expected.
    vacant_picture : (v,) int array
        Which picture says so of each.

    """

    def __init__(self, pictures: Sequence[Detections]) -> None:
        self._pictures = list(pictures) or [Detections.build(0)]
        counts = list(map(len, self._pictures))
        if max(counts) > MOST_DETECTIONS:
            self._pictures = list(map(_without_flood, self._pictures))
            counts = list(map(len, self._pictures))
        self.picture = np.arange(len(counts)).repeat(counts)
        self.is_described = _all_described(self._pictures, counts)
        columns = zip(*map(attrgetter(*ALWAYS_USED), self._pictures))
        vars(self).update(zip(ALWAYS_USED, map(np.concatenate, columns)))
        self._usable: NDArray[np.bool_] | None = None
        self.vacant_id, self.vacant_picture = np.empty(0, np.uint32), self.picture[:0]
        usable = _usable(self.covariance, self.position)
        if np.count_nonzero(usable) < len(usable):
            vacant = np.concatenate([each.is_vacant for each in self._pictures])
            self.vacant_id, self.vacant_picture = self.track_id[vacant], self.picture[vacant]
            self._usable = usable
            for name in ('picture', 'is_described', *ALWAYS_USED):
                setattr(self, name, getattr(self, name)[usable])

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.picture)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Put a column together, and keep it."""
        if name not in Detections.COLUMNS:
            raise AttributeError(name)
        column = np.concatenate([getattr(each, name) for each in self._pictures])
        column = column if self._usable is None else column[self._usable]
        self.__dict__[name] = column
        return column


def _without_flood(picture: Detections) -> Detections:
    if len(picture) <= MOST_DETECTIONS:
        return picture
    return picture.select(usable_rows(picture) | picture.is_vacant)


def _all_described(pictures: list[Detections], counts: list[int]) -> NDArray[np.bool_]:
    """Tell which rows of some pictures have an appearance template."""
    is_described, first = np.empty(sum(counts), np.bool_), 0
    for each, count in zip(pictures, counts):
        _describe(each.template, first, is_described)
        first += count
    return is_described


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


@compiled(types.void(types.Array(types.f4, 2, 'C', readonly=True), types.i8, types.b1[::1]))
def _describe(template: NDArray[np.float32], first: int, is_described: NDArray[np.bool_]) -> None:
    """Note which templates (n, 48) are not empty, in the rows from the first on."""
    for row in range(len(template)):
        filled = 0
        for bin in range(template.shape[1]):
            filled += template[row, bin] != 0.0
        is_described[first + row] = filled > 0
