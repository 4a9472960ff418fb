"""Sorting by counting: for keys that are small whole numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.compiled import inner

Indices = NDArray[np.int64]


@inner
def counted(key: Indices, keys: int) -> Indices:
    """Return the order that sorts keys (k,), not negative and below a number, stably."""
    place = np.zeros(keys + 1, np.int64)
    for one in key:
        place[one + 1] += 1
    for one in range(keys):
        place[one + 1] += place[one]
    order = np.empty(len(key), np.int64)
    for index in range(len(key)):
        order[place[key[index]]] = index
        place[key[index]] += 1
    return order
