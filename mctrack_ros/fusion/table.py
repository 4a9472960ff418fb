"""The fused tracks: one record each, seen as parallel arrays."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numba import from_dtype, types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.interfaces import TEMPLATE_SIZE

NEVER_NS = -(2**62)
PER_CAMERA = -1
PER_MODE = -2
"""Lengths in a column's shape: as many as there are cameras; as modes of motion."""

Scalar = TypeVar('Scalar', bound=np.generic)


class Column(Generic[Scalar]):
    """One value of every track: read as a view of the records, assigned by copying into them."""

    def __init__(self, kind: type[Scalar], *shape: int, fill: float = 0) -> None:
        self._kind, self._shape, self.fill = kind, shape, fill
        self.is_fixed = all(size > 0 for size in shape)

    def __set_name__(self, owner: type, name: str) -> None:
        """Learn what the column is called."""
        self._name = name

    def __get__(self, table: TrackTable, owner: type) -> NDArray[Scalar]:
        """Return the (n, ...) array."""
        return table.records[self._name]  # type: ignore[no-any-return]

    def __set__(self, table: TrackTable, values: ArrayLike) -> None:
        """Change the values of all tracks."""
        table.records[self._name] = values

    def field(self, cameras: int, modes: int) -> tuple[str, type[Scalar], tuple[int, ...]]:
        """Return the column's part of a record."""
        lengths = {PER_CAMERA: cameras, PER_MODE: modes}
        shape = tuple(lengths.get(size, size) for size in self._shape)
        return self._name, self._kind, shape


class TrackTable:
    """
    All tracks at one instant, sorted by id.

    Columns of one value come first in a record, so that those read together lie together.

    Parameters
    ----------
    lumps : (n,) array of bytes
        One record a track, which is copied whole instead of field by field.
    kind : structured dtype
        Of the records, whose fields are the columns.

    Attributes
    ----------
    records : (n,) structured array
        The same bytes as records.
    fixed : (n,) structured array
        Of these the columns whose shape is the same at every site, as compiled loops take them.
    track_id : (n,) uint32 array
    mean : (n, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (n, 4, 4) array
    mode_probability : (n, modes) array
        Of each mode of motion, if there are any.
    mode_mean, mode_covariance : (n, modes, 4), (n, modes, 4, 4) arrays
        The state in each; the track's own has the moments of their mixture.
    first_ns : (n,) int64 array
        Stamp of the first detection.
    seen_ns : (n,) int64 array
        Stamp of the last detection of its own.
    kept_ns : (n,) int64 array
        Stamp of the last detection of its own or of a group that it is in.
    seen_by_ns : (n, cameras) int64 array
        Stamp of the last detection of its own, by camera.
    local_id : (n, cameras) uint32 array
        What each camera called it then; 0: nothing.
    evidence : (n,) array
        Log-odds of being a target.
    missed : (n,) array
        Log-odds of having gone, as no camera has seen it, though they could have.
    pace_s : (n,) array
        Time between images of the camera that saw it last, alone or in a group, s; 0: not known.
    confirmed : (n,) bool array
    extent : (n, 2) float32 array
        Width and height, m; NaN: not told yet.
    template : (n, 48) float32 array
        Appearance; zero: none yet.
    class_id, kit : (n,) uint8 array
    class_lead_s : (n,) array
        For how much longer than all others its class was told, in all cameras, s.
    hidden_ns : (n, cameras) int64 array
        Stamp of the last group in which each camera saw it.
    group : (n,) uint32 array
        Smallest id of the group that it is in; 0: none.
    group_ns : (n,) int64 array
        Stamp of the last detection of that group.
    cameras : (n,) uint32 array
        Bits of the cameras that saw it this tick.
    shown_by : (n,) uint32 array
        Bits of the cameras whose latest image shows it, alone or in a group.
    origin : (n,) uint32 array
        Of which track it was part before it began; 0: of none.
    previous_id : (n,) uint32 array
        What it was called before this tick, where that changed; else 0.
    look : (n, 48) array
        Sum of the roots of its templates since it was last near another, weighted by time.
    look_s, judge_s : (n,) array
        For how long, in all cameras, that is; how long it must be to be judged, s.
    in_contact : (n,) bool array
        Whether it is near another.

    """

    track_id = Column(np.uint32)
    group = Column(np.uint32)
    cameras = Column(np.uint32)
    shown_by = Column(np.uint32)
    origin = Column(np.uint32)
    previous_id = Column(np.uint32)
    class_id = Column(np.uint8)
    kit = Column(np.uint8)
    confirmed = Column(np.bool_)
    in_contact = Column(np.bool_)
    evidence = Column(np.float64)
    missed = Column(np.float64)
    pace_s = Column(np.float64)
    class_lead_s = Column(np.float64)
    first_ns = Column(np.int64)
    seen_ns = Column(np.int64)
    kept_ns = Column(np.int64)
    group_ns = Column(np.int64, fill=NEVER_NS)
    look_s = Column(np.float64)
    judge_s = Column(np.float64)
    mean = Column(np.float64, 4)
    covariance = Column(np.float64, 4, 4)
    extent = Column(np.float32, 2, fill=np.nan)
    template = Column(np.float32, TEMPLATE_SIZE)
    look = Column(np.float64, TEMPLATE_SIZE)
    mode_probability = Column(np.float64, PER_MODE)
    mode_mean = Column(np.float64, PER_MODE, 4)
    mode_covariance = Column(np.float64, PER_MODE, 4, 4)
    seen_by_ns = Column(np.int64, PER_CAMERA, fill=NEVER_NS)
    hidden_ns = Column(np.int64, PER_CAMERA, fill=NEVER_NS)
    local_id = Column(np.uint32, PER_CAMERA)

    __slots__ = ('_lumps', '_room', 'fixed', 'records')

    def __init__(self, lumps: NDArray[np.void], kind: np.dtype[Any]) -> None:
        self._room = lumps
        self._hold(lumps, kind)

    def __len__(self) -> int:
        """Return the number of tracks."""
        return len(self.records)

    @classmethod
    def blank(cls, count: int, cameras: int, modes: int = 0) -> Self:
        """Return that many tracks of which nothing is known."""
        lump, kind = _blank(cameras, modes)
        return cls(lump.repeat(count), kind)

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Self:
        """Return a copy of the tracks that a mask or an index array picks."""
        return type(self)(self._lumps[index], self.records.dtype)

    def extended(self, other: Self) -> Self:
        """Return these tracks and then the other ones; where either are none, the others."""
        if not len(other):
            return self
        if not len(self):
            return other
        return type(self)(np.concatenate([self._lumps, other._lumps]), self.records.dtype)

    def append(self, other: Self) -> None:
        """Add other tracks behind these; there is room for more than there are."""
        before, count = len(self), len(self) + len(other)
        if count > len(self._room):
            self._room = np.empty(2 * count, self._lumps.dtype)
            self._room[:before] = self._lumps
        self._room[before:count] = other._lumps
        self._hold(self._room[:count], self.records.dtype)

    def remove(self, mask: NDArray[np.bool_]) -> Self:
        """Take out the tracks that a mask picks, and return them; those behind move up."""
        rows = mask.nonzero()[0]
        removed, lumps, first = self.select(rows), self._lumps, int(rows[0])
        for row, last in pairwise([*rows.tolist(), len(self)]):
            count = last - row - 1
            lumps[first : first + count] = lumps[row + 1 : last]
            first += count
        self._hold(self._room[:first], self.records.dtype)
        return removed

    def rename(self, changes: dict[int, int]) -> NDArray[np.intp]:
        """Change ids, old to new, all at once; return the order by which they ascend."""
        changed = np.isin(self.track_id, list(changes))
        self.previous_id[changed] = self.track_id[changed]
        for ids in (self.track_id, self.group, self.origin):
            ids[:] = [changes.get(one, one) for one in ids.tolist()]
        return np.argsort(self.track_id)

    def _hold(self, lumps: NDArray[np.void], kind: np.dtype[Any]) -> None:
        """Let these bytes be the tracks."""
        self._lumps = lumps
        self.records: NDArray[Any] = np.ndarray(len(lumps), kind, lumps)
        self.fixed: NDArray[Any] = np.ndarray(len(lumps), FIXED, lumps, 0, lumps.strides)


def _columns() -> list[Column[Any]]:
    return [column for column in vars(TrackTable).values() if isinstance(column, Column)]


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
