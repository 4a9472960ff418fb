"""Columns of the table of tracks: each stage declares its own."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

NEVER_NS = -(2**62)
PER_CAMERA = -1
PER_MODE = -2
"""Lengths in a column's shape: number of cameras; number of modes of motion."""

Scalar = TypeVar('Scalar', bound=np.generic)


class Columns:
    """
    The columns that one stage owns; `TrackTable` inherits those of all stages.

    Attributes
    ----------
    records : (n,) structured array
        One record a track.

    """

    __slots__ = ()
    records: NDArray[Any]

    def absorb(self, kept: int, dropped: int) -> None:
        """Give the track in one row what is known of its duplicate in another row."""
        raise NotImplementedError


class Column(Generic[Scalar]):
    """
    One value of every track: read as a view of the records, assigned by copying into them.

    Parameters
    ----------
    kind : type
        Of a value.
    *shape : int
        Of the values of one track; `PER_CAMERA` and `PER_MODE` are lengths.
    fill : float
        Value of a new track.

    """

    def __init__(self, kind: type[Scalar], *shape: int, fill: float = 0) -> None:
        self._kind, self._shape, self.fill = kind, shape, fill
        self.is_fixed = all(size > 0 for size in shape)
        self.size = np.dtype((kind, shape if self.is_fixed else ())).itemsize

    def __set_name__(self, owner: type, name: str) -> None:
        """Learn the column's name."""
        self._name = name

    def __get__(self, table: Columns, owner: type) -> NDArray[Scalar]:
        """Return the (n, ...) array."""
        return table.records[self._name]  # type: ignore[no-any-return]

    def __set__(self, table: Columns, values: ArrayLike) -> None:
        """Change the values of all tracks."""
        table.records[self._name] = values

    def field(self, cameras: int, modes: int) -> tuple[str, type[Scalar], tuple[int, ...]]:
        """Return the column's part of a record."""
        lengths = {PER_CAMERA: cameras, PER_MODE: modes}
        shape = tuple(lengths.get(size, size) for size in self._shape)
        return self._name, self._kind, shape
