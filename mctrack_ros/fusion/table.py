"""The fused tracks: one record each, of the columns of all stages."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any, Self

import numpy as np
from numba import from_dtype, types
from numpy.typing import NDArray

from mctrack_ros.fusion.association.config import AssociationColumns
from mctrack_ros.fusion.columns import Column, Columns
from mctrack_ros.fusion.existence.config import ExistenceColumns
from mctrack_ros.fusion.joint_tracker.config import OutputColumns
from mctrack_ros.fusion.management.config import ManagementColumns
from mctrack_ros.fusion.motion.config import MotionColumns
from mctrack_ros.fusion.reid.config import IdentityColumns

STAGES: tuple[type[Columns], ...] = (
    ManagementColumns,
    MotionColumns,
    AssociationColumns,
    ExistenceColumns,
    IdentityColumns,
    OutputColumns,
)


class TrackTable(
    ManagementColumns,
    MotionColumns,
    AssociationColumns,
    ExistenceColumns,
    IdentityColumns,
    OutputColumns,
):
    """
    All tracks at one instant, sorted by id.

    Small columns come first in a record, so that those read together lie together.

    Parameters
    ----------
    raw : (n,) array of bytes
        One record a track, which is copied whole instead of field by field.
    kind : structured dtype
        Of the records, whose fields are the columns.

    Attributes
    ----------
    records : (n,) structured array
        The same bytes as records.
    fixed : (n,) structured array
        Of these the columns whose shape is the same at every site, as compiled loops take them.

    """

    __slots__ = ('_raw', '_room', 'fixed', 'records')

    def __init__(self, raw: NDArray[np.void], kind: np.dtype[Any]) -> None:
        self._room = raw
        self._hold(raw, kind)

    def __len__(self) -> int:
        """Return the number of tracks."""
        return len(self.records)

    @classmethod
    def blank(cls, count: int, cameras: int, modes: int = 0) -> Self:
        """Return that many tracks of which nothing is known."""
        raw, kind = _blank(cameras, modes)
        return cls(raw.repeat(count), kind)

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Self:
        """Return a copy of the tracks that a mask or an index array picks."""
        return type(self)(self._raw[index], self.records.dtype)

    def extended(self, other: Self) -> Self:
        """Return these tracks and then the other ones; where either are none, the others."""
        if not len(other):
            return self
        if not len(self):
            return other
        return type(self)(np.concatenate([self._raw, other._raw]), self.records.dtype)

    def append(self, other: Self) -> None:
        """Add other tracks behind these; there is room for more than there are."""
        before, count = len(self), len(self) + len(other)
        if count > len(self._room):
            self._room = np.empty(2 * count, self._raw.dtype)
            self._room[:before] = self._raw
        self._room[before:count] = other._raw
        self._hold(self._room[:count], self.records.dtype)

    def remove(self, mask: NDArray[np.bool_]) -> Self:
        """Take out the tracks that a mask picks, and return them; those behind move up."""
        rows = mask.nonzero()[0]
        removed, raw, first = self.select(rows), self._raw, int(rows[0])
        for row, last in pairwise([*rows.tolist(), len(self)]):
            count = last - row - 1
            raw[first : first + count] = raw[row + 1 : last]
            first += count
        self._hold(self._room[:first], self.records.dtype)
        return removed

    def absorb(self, kept: int, dropped: int) -> None:
        """Give the track in one row what is known of its duplicate in another row."""
        for stage in STAGES:
            stage.absorb(self, kept, dropped)

    def _hold(self, raw: NDArray[np.void], kind: np.dtype[Any]) -> None:
        """Let these bytes be the tracks."""
        self._raw = raw
        self.records: NDArray[Any] = np.ndarray(len(raw), kind, raw)
        self.fixed: NDArray[Any] = np.ndarray(len(raw), FIXED, raw, 0, raw.strides)


def _columns() -> list[Column[Any]]:
    """Return the columns of all stages, fixed ones first, small ones before large ones."""
    columns = [
        each for stage in STAGES for each in vars(stage).values() if isinstance(each, Column)
    ]
    return sorted(columns, key=lambda column: (not column.is_fixed, column.size))


@cache
def _blank(cameras: int, modes: int) -> tuple[NDArray[np.void], np.dtype[Any]]:
    """Return the (1,) bytes of a track of which nothing is known, and the type of its record."""
    columns = _columns()
    fields = [column.field(cameras, modes) for column in columns]
    record = np.zeros(1, np.dtype(fields, align=True))
    for column, (name, *_) in zip(columns, fields):
        record[name] = column.fill
    return record.view(f'V{record.itemsize}'), record.dtype


FIXED = np.dtype([column.field(0, 0) for column in _columns() if column.is_fixed], align=True)
TRACKS = types.Array(from_dtype(FIXED), 1, 'A')
"""Records of the columns whose shape is the same at every site, for numpy and for numba: those
columns come first, so that they begin where the whole records do."""
