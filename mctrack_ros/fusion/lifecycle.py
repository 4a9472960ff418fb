"""When tracks are confirmed, hidden, merged and deleted; all in seconds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_STAMPS, INTS_1D, compiled, inner
from mctrack_ros.fusion.neighbours import is_near
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TRACKS, TrackTable

GROUP_MEMORY_S = 0.2
"""A track has left its group when no camera has seen it in one for so long, s."""
TWINS_ALONE_M = 2.0
"""Who is nearer than this to two that seem one may be one of them, m."""
WITNESSES, WITNESS_S = 3, 0.5
"""From so many sides, each within this time, s, one person cannot hide another."""

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]


def silence(table: TrackTable, stamp_ns: int) -> NDArray[np.float64]:
    """Return for how long, (n,) s, nothing has supported each track."""
    return (stamp_ns - table.kept_ns) / 1e9


def is_over(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that end now."""
    life, least = config.life, 1.5 * config.batching.period
    tentative_s, confirmed_s = max(life.tentative_time, least), max(life.coast_time, least)
    return _is_over(table.fixed, stamp_ns, tentative_s, confirmed_s)


@compiled(types.b1[::1](TRACKS, types.i8, types.f8, types.f8))
def _is_over(tracks: Any, stamp_ns: int, tentative_s: float, confirmed_s: float) -> Mask:
    over = np.empty(len(tracks), np.bool_)
    for row in range(len(tracks)):
        silent_s = (stamp_ns - tracks[row]['kept_ns']) / 1e9
        if tracks[row]['confirmed']:
            over[row] = silent_s > confirmed_s or tracks[row]['evidence'] < 0
        else:
            over[row] = silent_s > tentative_s
    return over


def is_published(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that are told to others, not only remembered."""
    limit = max(config.life.report_time, 1.5 * config.batching.period)
    return _is_supported(table.kept_ns, stamp_ns, limit)


@compiled(types.b1[::1](COLUMN_STAMPS, types.i8, types.f8))
def _is_supported(kept_ns: Indices, stamp_ns: int, limit_s: float) -> Mask:
    supported = np.empty(len(kept_ns), np.bool_)
    for row in range(len(kept_ns)):
        supported[row] = (stamp_ns - kept_ns[row]) / 1e9 <= limit_s
    return supported


def leave_groups(table: TrackTable, stamp_ns: int) -> None:
    """Forget the group of what has not been seen in one for a while."""
    table.group[stamp_ns - table.group_ns > GROUP_MEMORY_S * 1e9] = 0


class DuplicateWatch:
    """
    Notices two tracks that follow one target: near for a while, told apart by no camera.

    Parameters
    ----------
    seconds : float
        For how long, s.

    """

    def __init__(self, seconds: float) -> None:
        self._time_ns = round(seconds * 1e9)
        self._since_ns: dict[tuple[int, int], int] = {}

    def find(
        self, table: TrackTable, one: Indices, other: Indices, stamp_ns: int
    ) -> list[tuple[int, int]]:
        """Return which pairs of rows (k,), (k,) are one target by now: (kept, dropped)."""
        if not len(one):
            self._since_ns.clear()
            return []
        rows = list(zip(one.tolist(), other.tolist()))
        names = list(zip(table.track_id[one].tolist(), table.track_id[other].tolist()))
        self._since_ns = {pair: self._since_ns.get(pair, stamp_ns) for pair in names}
        chosen: list[tuple[int, int]] = []
        used: set[int] = set()
        for pair, (first, second) in zip(names, rows):
            is_due = stamp_ns - self._since_ns[pair] >= self._time_ns
            if is_due and not used & {first, second}:
                used |= {first, second}
                newer_is_better = table.confirmed[second] and not table.confirmed[first]
                chosen.append((second, first) if newer_is_better else (first, second))
        return chosen


def unresolved_pairs(
    table: TrackTable, one: Indices, other: Indices, distance: float
) -> tuple[Indices, Indices, Mask]:
    """
    Return those pairs of rows (k,), (k,) that are so near and told apart by no camera.

    And of which of them, (m,), either is in a group.
    """
    unresolved, grouped = _unresolved(table.fixed, table.seen_by_ns, one, other, distance)
    return one[unresolved], other[unresolved], grouped


@inner
def _company(tracks: Any, own: int) -> int:
    """Return how many confirmed tracks are near one that is confirmed itself."""
    mean, confirmed, count = tracks['mean'], tracks['confirmed'], 0
    for other in range(len(tracks) if confirmed[own] else 0):
        near = other != own and is_near(mean, own, other, TWINS_ALONE_M)
        count += near and confirmed[other]
    return count


def alone(
    table: TrackTable, one: Indices, other: Indices, stamp_ns: int
) -> tuple[Indices, Indices]:
    """
    Return those pairs of rows (k,), (k,) that are by themselves and seen from many sides.

    No third confirmed track is within `TWINS_ALONE_M` of either, and `WITNESSES` see them.
    """
    if not len(one):
        return one, other
    wanted = _alone(table.fixed, table.seen_by_ns, one, other, stamp_ns)
    return one[wanted], other[wanted]


@compiled(
    types.b1[::1](TRACKS, types.Array(types.i8, 2, 'A', readonly=True), INTS_1D, INTS_1D, types.i8)
)
def _alone(
    tracks: Any, seen_by_ns: NDArray[np.int64], one: Indices, other: Indices, stamp_ns: int
) -> Mask:
    """Return which pairs (k,) are, see `alone`."""
    wanted = np.empty(len(one), np.bool_)
    for pair in range(len(one)):
        first, second, witnesses = one[pair], other[pair], 0
        for camera in range(seen_by_ns.shape[1]):
            last_ns = max(seen_by_ns[first, camera], seen_by_ns[second, camera])
            witnesses += stamp_ns - last_ns < WITNESS_S * 1e9
        wanted[pair] = (
            witnesses >= WITNESSES and _company(tracks, first) == _company(tracks, second) == 1
        )
    return wanted


@compiled(
    types.Tuple([types.i8[::1], types.b1[::1]])(
        TRACKS, types.Array(types.i8, 2, 'A', readonly=True), INTS_1D, INTS_1D, types.f8
    )
)
def _unresolved(
    tracks: Any, seen_by_ns: NDArray[np.int64], one: Indices, other: Indices, distance: float
) -> tuple[Indices, Mask]:
    """
    Return which pairs are so near, and no picture of the tick shows both of.

    And of which of those either is in a group.
    """
    mean, cameras, group = tracks['mean'], tracks['cameras'], tracks['group']
    unresolved = np.empty(len(one), np.bool_)
    for pair in range(len(one)):
        first, second = one[pair], other[pair]
        unresolved[pair] = is_near(mean, first, second, distance)
        for camera in range(seen_by_ns.shape[1]):
            both = (cameras[first] & cameras[second]) >> camera & 1
            if both and seen_by_ns[first, camera] == seen_by_ns[second, camera]:
                unresolved[pair] = False
    left = np.flatnonzero(unresolved)
    return left, (group[one[left]] | group[other[left]]) != 0


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
    own, other = table.extent[kept], table.extent[dropped]
    table.extent[kept] = np.where(np.isnan(own), other, own)
    table.previous_id[kept] = table.track_id[dropped]
