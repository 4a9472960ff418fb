"""When tracks are confirmed, hidden, merged and deleted; all in seconds."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_1D, INTS_1D, compiled
from mctrack_ros.fusion.neighbours import near_pairs
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable

GROUP_MEMORY_S = 0.2
"""A track has left its group when no camera has seen it in one for so long, s."""
WITNESSES, WITNESS_S = 3, 0.5
"""From so many sides, each within this time, s, one person cannot hide another."""

Mask = NDArray[np.bool_]
Ids = NDArray[np.uint32]
Indices = NDArray[np.int64]
_IDS = types.Array(types.u4, 1, 'A', readonly=True)


def silence(table: TrackTable, stamp_ns: int) -> NDArray[np.float64]:
    """Return for how long, (n,) s, nothing has supported each track."""
    return (stamp_ns - table.kept_ns) / 1e9


def is_over(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that end now."""
    life, least = config.life, 1.5 * config.batching.period
    return _is_over(
        table.confirmed,
        table.evidence,
        table.kept_ns,
        stamp_ns,
        max(life.tentative_time, least),
        max(life.coast_time, least),
    )


@compiled(
    types.b1[::1](
        types.Array(types.b1, 1, 'A', readonly=True),
        COLUMN_1D,
        types.Array(types.i8, 1, 'A', readonly=True),
        types.i8,
        types.f8,
        types.f8,
    )
)
def _is_over(
    confirmed: Mask,
    evidence: NDArray[np.float64],
    kept_ns: Indices,
    stamp_ns: int,
    tentative_s: float,
    confirmed_s: float,
) -> Mask:
    over = np.empty(len(confirmed), np.bool_)
    for row in range(len(confirmed)):
        silent_s = (stamp_ns - kept_ns[row]) / 1e9
        if confirmed[row]:
            over[row] = silent_s > confirmed_s or evidence[row] < 0
        else:
            over[row] = silent_s > tentative_s
    return over


def is_published(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that are told to others, not only remembered."""
    limit = max(config.life.report_time, 1.5 * config.batching.period)
    return silence(table, stamp_ns) <= limit


def leave_groups(table: TrackTable, stamp_ns: int) -> None:
    """Forget the group of what has not been seen in one for a while."""
    table.group[stamp_ns - table.group_ns > GROUP_MEMORY_S * 1e9] = 0


class DuplicateWatch:
    """
    Notices two tracks that follow one target: near for a while, told apart by no camera.

    Parameters
    ----------
    distance : float
        How near, m.
    seconds : float
        For how long, s.
    alone : float
        Without any third confirmed track nearer than this to either, m, and seen by three cameras
        or more; then it does not matter that one has them in a group. 0: whoever is near, but in
        no group.

    """

    def __init__(self, distance: float, seconds: float, alone: float = 0.0) -> None:
        self._distance, self._alone = distance, alone
        self._time_ns = round(seconds * 1e9)
        self._since_ns: dict[tuple[int, int], int] = {}

    def find(self, table: TrackTable, stamp_ns: int) -> list[tuple[int, int]]:
        """Return pairs of rows (kept, dropped) that are one target by now."""
        near = [
            (int(table.track_id[one]), int(table.track_id[other]), one, other)
            for one, other in self._near_pairs(table, stamp_ns)
        ]
        self._since_ns = {pair[:2]: self._since_ns.get(pair[:2], stamp_ns) for pair in near}
        due = [
            (one, other)
            for first, second, one, other in near
            if stamp_ns - self._since_ns[first, second] >= self._time_ns
        ]
        chosen, used = [], set[int]()
        for one, other in due:
            if not used & {one, other}:
                used |= {one, other}
                newer_is_better = table.confirmed[other] and not table.confirmed[one]
                chosen.append((other, one) if newer_is_better else (one, other))
        return chosen

    def _near_pairs(self, table: TrackTable, stamp_ns: int) -> list[tuple[int, int]]:
        """Return the pairs of rows that are near, and that no picture of the tick tells apart."""
        one, other = near_pairs(table.mean, self._distance)
        if not len(one):
            return []
        unresolved = _unresolved(table.seen_by_ns, table.cameras, one, other)
        if self._alone:
            seen = stamp_ns - table.seen_by_ns < WITNESS_S * 1e9
            unresolved &= (seen[one] | seen[other]).sum(axis=1) >= WITNESSES
            count = _company(table, self._alone)
            unresolved &= (count[one] == 1) & (count[other] == 1)
        else:
            unresolved &= (table.group[one] == 0) & (table.group[other] == 0)
        return list(zip(one[unresolved].tolist(), other[unresolved].tolist()))


def _company(table: TrackTable, reach: float) -> Indices:
    """Return how many confirmed tracks are within reach, m, of each that is confirmed itself."""
    one, other = near_pairs(table.mean, reach)
    firm = table.confirmed[one] & table.confirmed[other]
    return np.bincount(np.append(one[firm], other[firm]), minlength=len(table))


@compiled(types.b1[::1](types.Array(types.i8, 2, 'A', readonly=True), _IDS, INTS_1D, INTS_1D))
def _unresolved(seen_by_ns: NDArray[np.int64], cameras: Ids, one: Indices, other: Indices) -> Mask:
    """Return which pairs (k,) no picture of the tick shows both of."""
    unresolved = np.empty(len(one), np.bool_)
    for pair in range(len(one)):
        first, second, unresolved[pair] = one[pair], other[pair], True
        for camera in range(seen_by_ns.shape[1]):
            both = (cameras[first] & cameras[second]) >> camera & 1
            if both and seen_by_ns[first, camera] == seen_by_ns[second, camera]:
                unresolved[pair] = False
    return unresolved


def absorb(table: TrackTable, kept: int, dropped: int) -> None:
    """Give a track what is known of its duplicate."""
    newer = table.seen_by_ns[dropped] > table.seen_by_ns[kept]
    table.local_id[kept] = np.where(newer, table.local_id[dropped], table.local_id[kept])
    table.seen_by_ns[kept] = np.maximum(table.seen_by_ns[kept], table.seen_by_ns[dropped])
    for name in ('seen_ns', 'kept_ns', 'evidence'):
        values = getattr(table, name)
        values[kept] = max(values[kept], values[dropped])
    table.cameras[kept] |= table.cameras[dropped]
    if np.trace(table.covariance[dropped]) < np.trace(table.covariance[kept]):
        for name in ('mean', 'covariance', 'mode_probability', 'mode_mean', 'mode_covariance'):
            getattr(table, name)[kept] = getattr(table, name)[dropped]
    if not table.template[kept].any():
        table.template[kept] = table.template[dropped]
    table.previous_id[kept] = table.track_id[dropped]
