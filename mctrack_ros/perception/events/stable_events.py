"""Who is tracked in a stable manner: alone, by a track of his own (event E6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

Ints = NDArray[np.int64]


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

    def step(
        self, in_view: PersonsInView, group_size: Ints, part: Ints, stamp_ns: int
    ) -> list[int]:
        """
        Return the rows of those who are stable from now on.

        Parameters
        ----------
        in_view : PersonsInView
            Everybody in view.
        group_size : (n,) int64 array
            How many are in the group of each, himself too.
        part : (n,) int64 array
            The part of the foreground each is in; -1: not seen.
        stamp_ns : int
            Time of the image, ns.

        """
        alone = (group_size == 1) & (in_view.local_id > 0) & (part >= 0)
        rows = dict(zip(in_view.key[alone].tolist(), np.flatnonzero(alone).tolist()))
        self._since_ns = {key: self._since_ns.get(key, stamp_ns) for key in rows}
        self._reported &= rows.keys()
        ripe = [
            key
            for key, since_ns in self._since_ns.items()
            if key not in self._reported and stamp_ns - since_ns >= self._stable_ns
        ]
        self._reported.update(ripe)
        return [rows[key] for key in ripe]
