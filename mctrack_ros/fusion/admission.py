"""Which detections can be used at all."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
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

    Their columns, as those of `Detections`, are put together when they are first asked for.

    Parameters
    ----------
    pictures : sequence of Detections
        One each.

    Attributes
    ----------
    picture : (m,) int array
        Which picture each is of.
    vacant_id : (v,) uint32 array
        Targets of which pictures say that they are not where they are expected.
    vacant_picture : (v,) int array
        Which picture says so of each.

    """

    def __init__(self, pictures: Sequence[Detections]) -> None:
        self._pictures = [
            each.select(usable_rows(each) | each.is_vacant)
            if len(each) > MOST_DETECTIONS
            else each
            for each in pictures
        ] or [Detections.build(0)]
        self.picture = np.arange(len(self._pictures)).repeat(list(map(len, self._pictures)))
        self._usable: NDArray[np.bool_] | None = None
        self.vacant_id, self.vacant_picture = np.empty(0, np.uint32), self.picture[:0]
        usable = _usable(self.covariance, self.position)
        if np.count_nonzero(usable) < len(usable):
            vacant = np.concatenate([each.is_vacant for each in self._pictures])
            self.vacant_id, self.vacant_picture = self.track_id[vacant], self.picture[vacant]
            self._usable, self.picture = usable, self.picture[usable]
            del self.covariance, self.position, self.track_id

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.picture)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Put a column together, and keep it."""
        if name not in Detections.COLUMNS:
            raise AttributeError(name)
        column = self._joined([getattr(each, name) for each in self._pictures])
        self.__dict__[name] = column
        return column

    @cached_property
    def is_described(self) -> NDArray[np.bool_]:
        """Tell which rows, (m,), have an appearance template; the templates stay apart."""
        return self._joined([_described(each.template) for each in self._pictures])

    def _joined(self, columns: list[NDArray[Any]]) -> NDArray[Any]:
        """Put columns of all pictures together, the usable rows of them."""
        column = np.concatenate(columns)
        return column if self._usable is None else column[self._usable]


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


@compiled(types.b1[::1](types.Array(types.f4, 2, 'C', readonly=True)))
def _described(template: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return which templates (n, 48) are not empty."""
    is_described = np.zeros(len(template), np.bool_)
    for row in range(len(template)):
        filled = 0
        for bin in range(template.shape[1]):
            filled += template[row, bin] != 0.0
        is_described[row] = filled > 0
    return is_described
