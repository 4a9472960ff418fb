"""Parallel arrays for one instant: what every interface of the graph is made of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, slots=True)
class Column:
    """
    One array of a row type: its element type, its shape behind the first axis, its default.

    Attributes
    ----------
    dtype : str
        NumPy type code without byte order, for example ``f4``.
    shape : tuple of int
        Shape of one row's value; ``()`` for a number.
    fill : float
        What a column is filled with where nothing is known.
    absent : number or nested tuple, optional
        Each row's value where a message lacks the column; None: every message must have it.

    """

    dtype: str
    shape: tuple[int, ...] = ()
    fill: float = 0.0
    absent: Any = None


AnyRows = TypeVar('AnyRows', bound='Rows')


class Stamped(Protocol):
    """What is known of one image."""

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        ...

    def __len__(self) -> int:
        """Return how many there are, rows for example."""
        ...

    def at(self, stamp_ns: int) -> Self:
        """Return the same under another stamp, ns."""
        ...


class Message(Stamped, Protocol):
    """
    A message of one image on a topic below its camera's: rows, or a mask.

    Attributes
    ----------
    TOPIC : str
        Where, below the camera's own topic.
    ROS_TYPE : str
        As which message.

    """

    TOPIC: ClassVar[str]
    ROS_TYPE: ClassVar[str]

    @classmethod
    def build(cls, stamp_ns: int) -> Self:
        """Return the message of an image in which nothing is found."""
        ...


MOST_WAITING = 8
"""Images of a camera of which messages are missing; of more, the oldest are given up."""
POSITION = Column('f4', (3,), float('nan'))


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """
    Base of the row types: a stamp, ground positions and arrays that share their first axis.

    A subclass names its columns in ``COLUMNS``, in the order of its fields, with the element
    types that travel, so encoding loses nothing. Arrays are checked and made read-only. ``TOPIC``
    is where they are told: by a camera below its own topic, by fusion as it is.

    Raises
    ------
    ValueError
        If an array has another shape or element type than its column.

    """

    COLUMNS: ClassVar[dict[str, Column]] = {}
    TOPIC: ClassVar[str] = ''
    ROS_TYPE: ClassVar[str] = 'sensor_msgs/msg/PointCloud2'
    LAYOUT: ClassVar[tuple[tuple[str, np.dtype[Any], tuple[int, ...], float], ...]] = ()
    NONE: ClassVar[tuple[NDArray[Any], ...]] = ()

    stamp_ns: int
    position: NDArray[np.float32]

    def __init_subclass__(cls) -> None:
        """Work out once what every row of a type needs: its columns, and those of no rows."""
        cls.LAYOUT = tuple(
            (name, np.dtype(column.dtype), column.shape, column.fill)
            for name, column in cls.COLUMNS.items()
        )
        cls.NONE = tuple(np.zeros((0, *shape), dtype) for _, dtype, shape, _ in cls.LAYOUT)
        for none in cls.NONE:
            none.setflags(write=False)

    def __post_init__(self) -> None:
        """Check every column against its declaration and freeze it."""
        columns = [getattr(self, name) for name in self.COLUMNS]
        self._check(columns)
        _fill(self, _frozen(columns))

    @classmethod
    def _check(cls, columns: Sequence[NDArray[Any]]) -> None:
        count = len(columns[0])
        for (name, dtype, shape, _), array in zip(cls.LAYOUT, columns):
            if array.shape != (count, *shape) or array.dtype != dtype:
                raise ValueError(
                    f'{name} has shape {array.shape} and type {array.dtype}, '
                    f'expected {(count, *shape)} and {dtype}'
                )

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.position)

    @classmethod
    def build(cls, stamp_ns: int, **columns: ArrayLike) -> Self:
        """
        Make rows from some columns; the others are filled with their defaults.

        Parameters
        ----------
        stamp_ns : int
            Time of the rows, ns.
        **columns : array_like
            Values by column name, one row each; converted to the column's element type.

        Raises
        ------
        ValueError
            If a column is not known or lengths differ.

        """
        if not columns:
            return _made(cls, int(stamp_ns), cls.NONE)
        unknown = columns.keys() - cls.COLUMNS.keys()
        if unknown:
            raise ValueError(f'{cls.__name__} has no column {sorted(unknown)[0]!r}')
        first = next(iter(columns.values()))
        count = len(first if isinstance(first, np.ndarray) else np.asarray(first))
        arrays: list[NDArray[Any]] = []
        for name, dtype, shape, fill in cls.LAYOUT:
            if name in columns:
                given = np.array(columns[name], dtype, order='C')
                arrays.append(given if given.size else given.reshape((-1, *shape)))
            else:
                arrays.append(np.zeros((count, *shape), dtype))
                if fill != 0.0:
                    arrays[-1][...] = fill
        cls._check(arrays)
        return _made(cls, int(stamp_ns), _locked(arrays))

    @classmethod
    def adopt(cls, stamp_ns: int, columns: Sequence[NDArray[Any]]) -> Self:
        """Make rows of all columns, in their order, which nobody else writes any more."""
        return _made(cls, stamp_ns, _locked(columns))

    @classmethod
    def joined(cls, stamp_ns: int, parts: Sequence[Self]) -> Self:
        """Return the rows of several, one after the other, under one stamp."""
        if not parts:
            return cls.build(stamp_ns)
        columns = [np.concatenate([getattr(part, name) for part in parts]) for name in cls.COLUMNS]
        return _made(cls, stamp_ns, _locked(columns))

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Self:
        """Return the rows that a mask or an index array picks, in its order."""
        if index.dtype == np.bool_ and index.all():
            return self
        columns = [getattr(self, name)[index] for name in self.COLUMNS]
        return _made(type(self), self.stamp_ns, _locked(columns))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the columns' bytes: between processes this is what rows cost."""
        data = [getattr(self, name).tobytes() for name in self.COLUMNS]
        return _unpickled, (type(self), self.stamp_ns, len(self), data)

    def at(self, stamp_ns: int) -> Self:
        """Return the same rows under another stamp, ns."""
        return _made(type(self), stamp_ns, [getattr(self, name) for name in self.COLUMNS])

    def replace(self, **columns: ArrayLike) -> Self:
        """Return the same rows with some columns exchanged."""
        kept = {name: getattr(self, name) for name in self.COLUMNS} | columns
        return type(self).build(self.stamp_ns, **kept)


def _frozen(columns: Iterable[NDArray[Any]]) -> list[NDArray[Any]]:
    """
    Return read-only arrays as compiled loops take them: row after row, without gaps.

    They are views where they can be: whoever made the arrays may go on writing. Of at most one
    row NumPy calls any strides contiguous, but joins such arrays column by column: it is copied.
    """
    views = [
        np.ascontiguousarray(column).view() if len(column) > 1 else np.array(column, order='C')
        for column in columns
    ]
    for view in views:
        view.setflags(write=False)
    return views


def _locked(columns: Sequence[NDArray[Any]]) -> Sequence[NDArray[Any]]:
    """Make arrays read-only that nobody else has."""
    for column in columns:
        column.setflags(write=False)
    return columns


def _made(kind: type[AnyRows], stamp_ns: int, columns: Iterable[NDArray[Any]]) -> AnyRows:
    """Make rows of read-only columns that are known to be right."""
    rows = object.__new__(kind)
    object.__setattr__(rows, 'stamp_ns', stamp_ns)
    _fill(rows, columns)
    return rows


def _fill(rows: Rows, columns: Iterable[NDArray[Any]]) -> None:
    put = object.__setattr__
    for name, column in zip(rows.COLUMNS, columns):
        put(rows, name, column)


def _unpickled(kind: type[AnyRows], stamp_ns: int, count: int, data: list[bytes]) -> AnyRows:
    """Make rows of the columns' bytes, which nobody can write."""
    columns = [
        np.ndarray((count, *shape), dtype, each)
        for each, (_, dtype, shape, _) in zip(data, kind.LAYOUT)
    ]
    return _made(kind, stamp_ns, columns)
