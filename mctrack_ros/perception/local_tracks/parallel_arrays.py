"""Arrays of equal length, one row for each of what is tracked."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray


class ParallelArrays:
    """
    Base of tables; the value of a new row is the class attribute of an array's name.

    Attributes
    ----------
    local_id : (n,) int64 array
        Counted from 1, never reused.

    """

    NEW: ClassVar[dict[str, NDArray[Any]]]
    local_id: NDArray[np.int64] = np.zeros((), np.int64)

    def __init_subclass__(cls) -> None:
        """Collect the arrays."""
        named = {**vars(ParallelArrays), **vars(cls)}
        cls.NEW = {name: value for name, value in named.items() if isinstance(value, np.ndarray)}

    def __init__(self) -> None:
        self._next_id = 1
        self.clear()

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.local_id)

    def clear(self) -> None:
        """Drop all rows; ids go on."""
        for name, value in self.NEW.items():
            setattr(self, name, np.zeros((0, *value.shape), value.dtype))

    def append(self, count: int, **given: NDArray[Any]) -> None:
        """Append rows with the next ids; arrays that are not given get the value of a new row."""
        given['local_id'] = np.arange(self._next_id, self._next_id + count)
        self._next_id += count
        for name, value in self.NEW.items():
            added = given[name] if name in given else np.repeat(value[None], count, axis=0)
            setattr(self, name, np.concatenate([getattr(self, name), added]))

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Keep the rows that a mask, (n,), picks."""
        for name in self.NEW:
            setattr(self, name, getattr(self, name)[mask])
