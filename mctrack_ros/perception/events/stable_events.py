"""Who is tracked in a stable manner: alone (event E6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]


class StableEvents:
    """
    Tells once of each who has been alone for a while, after whatever else happened to him.

    Every other event takes precedence (event-tracking paper, Table 1 and Algorithm 4): whoever
    comes, merges, or splits off is not stable until he has been tracked alone for some time.

    Parameters
    ----------
    stable_s : float
        How long, s.

    """

    def __init__(self, stable_s: float) -> None:
        self._stable_ns = round(stable_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget who is stable."""
        self._since_ns: dict[int, int] = {}
        self._reported: set[int] = set()

    def step(self, key: Ints, alone: Booleans, stamp_ns: int) -> list[int]:
        """
        Return the rows of those who are stable from now on.

        Parameters
        ----------
        key : (n,) int64 array
            Of everybody in view.
        alone : (n,) bool array
            Who is tracked in this image, in no group.
        stamp_ns : int
            Time of the image, ns.

        """
        rows = dict(zip(key[alone].tolist(), np.flatnonzero(alone).tolist()))
        self._since_ns = {one: self._since_ns.get(one, stamp_ns) for one in rows}
        self._reported &= rows.keys()
        ripe = [
            one
            for one, since_ns in self._since_ns.items()
            if one not in self._reported and stamp_ns - since_ns >= self._stable_ns
        ]
        self._reported.update(ripe)
        return [rows[one] for one in ripe]
