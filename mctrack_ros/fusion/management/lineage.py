"""Whose trajectory a new track shares: that of the group out of which it came."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.management.initiation import CROWD_M
from mctrack_ros.fusion.neighbours import nearest
from mctrack_ros.fusion.table import TrackTable

MEMORY_S = 10.0
"""For how long it is remembered that somebody was lost, s."""

SPEED = 2.0
"""How fast such a one may have gone on, m/s."""

RECENT_S = 0.5
"""A track that nothing has supported for longer is nobody's origin, s."""


class Lineage:
    """
    Finds the track that a new one was part of until now (event-tracking paper, Definition 6).

    Several who were one object from the first are one track until they split; what then begins
    beside that track has its past. Where somebody was lost near by of late it is rather him,
    found again, and shares nobody's past.
    """

    def __init__(self) -> None:
        self._lost: deque[tuple[int, int, list[float]]] = deque()

    def note_lost(self, removed: TrackTable, stamp_ns: int) -> None:
        """Remember where confirmed tracks ended."""
        lost = removed.select(removed.confirmed)
        self._lost += [
            (stamp_ns, *one) for one in zip(lost.track_id.tolist(), lost.mean[:, :2].tolist())
        ]

    def note_found(self, names: Iterable[int]) -> None:
        """Forget that somebody was lost: he is there again."""
        found = set(names)
        self._lost = deque(one for one in self._lost if one[1] not in found)

    def origins(
        self, begun: NDArray[np.float64], table: TrackTable, stamp_ns: int
    ) -> NDArray[np.uint32]:
        """Return the ids of the tracks that those who have begun, (k, 4), come out of; or 0."""
        present = table.confirmed & (stamp_ns - table.kept_ns <= RECENT_S * 1e9)
        row, gap = nearest(begun, table.mean, present)
        origin = np.zeros(len(begun), np.uint32)
        for index in (gap < CROWD_M).nonzero()[0].tolist():
            if not self._may_be_found_again(begun[index, :2].tolist(), stamp_ns):
                origin[index] = table.track_id[row[index]]
        return origin

    def _may_be_found_again(self, place: list[float], stamp_ns: int) -> bool:
        while self._lost and not 0 <= stamp_ns - self._lost[0][0] <= MEMORY_S * 1e9:
            self._lost.popleft()
        return any(
            math.dist(place, there) < CROWD_M + SPEED * (stamp_ns - when_ns) * 1e-9
            for when_ns, _, there in self._lost
        )
