"""When two tracks are of one target, and what is kept of both."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled, inner
from mctrack_ros.fusion.neighbours import is_near
from mctrack_ros.fusion.table import TRACKS, TrackTable

TENTATIVE_GAIN = 4.0
"""Two that are not confirmed become one so many times as fast: nobody was told of them."""
TOLD_LOSS = 5.0
"""An image that shows both takes away what so many others in one place add."""
ENDING = 0.5
"""Where either would end, so much of the time is enough: the other has taken all its support."""
TWINS_ALONE_M = 2.0
"""Who is nearer than this to two that seem one may be one of them, m."""
WITNESSES, WITNESS_S = 3, 0.5
"""From so many sides, each within this time, s, one person cannot hide another."""

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]
Floats = NDArray[np.float64]


class ClosePairs(NamedTuple):
    """
    Tracks that are near each other, two and two.

    Attributes
    ----------
    one, other : (k,) int64 arrays
        Rows of the table.
    gain : (k,) array
        By how much the tick brings them nearer to being one target, s.
    reported : (k,) bool array
        Whether an image of the tick shows both.
    grouped : (k,) bool array
        Whether either is in a group.

    """

    one: Indices
    other: Indices
    gain: Floats
    reported: Mask
    grouped: Mask

    def select(self, wanted: Mask) -> ClosePairs:
        """Return the pairs of a (k,) mask."""
        return ClosePairs._make(column[wanted] for column in self)


class Doubt(NamedTuple):
    """
    Whether two tracks are two.

    Attributes
    ----------
    seconds : float
        What has come together of the time after which they are one, s.
    began_ns : int
        Stamp of the tick since which they are in doubt, ns.
    reported : bool
        Whether an image of the last tick shows both.

    """

    seconds: float
    began_ns: int
    reported: bool


class DuplicateWatch:
    """
    Notices two tracks that follow one target: near for a while, hardly told apart by a camera.

    Parameters
    ----------
    seconds : float
        For how long, if they are in one place, s.

    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._doubts: dict[tuple[int, int], Doubt] = {}

    def clear(self) -> None:
        """Forget all pairs: none are near."""
        self._doubts.clear()

    def forget(self, track_id: int) -> None:
        """Forget the pairs of one who is elsewhere."""
        for pair in [pair for pair in self._doubts if track_id in pair]:
            del self._doubts[pair]

    def doubts(self, share: float) -> dict[tuple[int, int], Doubt]:
        """Return those of which so much of the time has come together, by ids; none told apart."""
        least = share * self._seconds
        return {
            pair: doubt
            for pair, doubt in self._doubts.items()
            if doubt.seconds >= least and not doubt.reported
        }

    def find(
        self, table: TrackTable, pairs: ClosePairs, over: Mask, stamp_ns: int
    ) -> list[tuple[int, int]]:
        """
        Add a tick; return which pairs of rows are one target by now: (kept, dropped).

        Of the tracks, (n,) are over.
        """
        before, self._doubts = self._doubts, {}
        chosen: list[tuple[int, int]] = []
        used: set[int] = set()
        one, other = pairs.one, pairs.other
        names = zip(table.track_id[one].tolist(), table.track_id[other].tolist())
        columns = one.tolist(), other.tolist(), pairs.gain.tolist(), pairs.reported.tolist()
        for pair, first, second, gain, reported in zip(names, *columns):
            seconds, began_ns = 0.0, stamp_ns
            if pair in before:
                seconds, began_ns = before[pair].seconds + gain, before[pair].began_ns
            if reported and seconds <= 0.0:
                continue  # nothing is left: they begin anew
            self._doubts[pair] = Doubt(seconds, began_ns, reported)
            limit = self._seconds * (ENDING if over[first] or over[second] else 1.0)
            if seconds >= limit and not reported and not used & {first, second}:
                used |= {first, second}
                newer_is_better = table.confirmed[second] and not table.confirmed[first]
                chosen.append((second, first) if newer_is_better else (first, second))
        return chosen


def close_pairs(
    table: TrackTable, one: Indices, other: Indices, distance: float, seconds: float
) -> ClosePairs:
    """
    Return those pairs of rows (k,), (k,) that are nearer than a distance, m.

    A tick of so many seconds counts for all of them in one place, for none at that distance.
    """
    return ClosePairs(*_close(table.fixed, table.seen_by_ns, one, other, distance, seconds))


@compiled(
    types.Tuple([types.i8[::1], types.i8[::1], types.f8[::1], types.b1[::1], types.b1[::1]])(
        TRACKS, types.Array(types.i8, 2, 'A', readonly=True), INTS_1D, INTS_1D, types.f8, types.f8
    )
)
def _close(
    tracks: Any,
    seen_by_ns: NDArray[np.int64],
    one: Indices,
    other: Indices,
    distance: float,
    seconds: float,
) -> tuple[Indices, Indices, Floats, Mask, Mask]:
    """Return the columns of `ClosePairs`."""
    mean, cameras, group = tracks['mean'], tracks['cameras'], tracks['group']
    confirmed, gain = tracks['confirmed'], np.empty(len(one))
    reported, close = np.zeros(len(one), np.bool_), np.empty(len(one), np.bool_)
    for pair in range(len(one)):
        first, second = one[pair], other[pair]
        close[pair] = is_near(mean, first, second, distance)
        if not close[pair]:
            continue
        for camera in range(seen_by_ns.shape[1]):
            both = (cameras[first] & cameras[second]) >> camera & 1
            if both and seen_by_ns[first, camera] == seen_by_ns[second, camera]:
                reported[pair] = True
        apart = np.hypot(mean[second, 0] - mean[first, 0], mean[second, 1] - mean[first, 1])
        gain[pair] = seconds * (1.0 - apart / distance)
        if reported[pair]:
            gain[pair] = -TOLD_LOSS * seconds
        elif not (confirmed[first] or confirmed[second]):
            gain[pair] *= TENTATIVE_GAIN
    left = np.flatnonzero(close)
    first, second = one[left], other[left]
    return first, second, gain[left], reported[left], (group[first] | group[second]) != 0


@inner
def _company(tracks: Any, own: int) -> int:
    """Return how many confirmed tracks are near one that is confirmed itself."""
    mean, confirmed, count = tracks['mean'], tracks['confirmed'], 0
    for other in range(len(tracks) if confirmed[own] else 0):
        near = other != own and is_near(mean, own, other, TWINS_ALONE_M)
        count += near and confirmed[other]
    return count


def alone(table: TrackTable, pairs: ClosePairs, stamp_ns: int) -> ClosePairs:
    """
    Return those pairs that are by themselves and seen from many sides.

    No third confirmed track is within `TWINS_ALONE_M` of either, and `WITNESSES` see them.
    """
    if not len(pairs.one):
        return pairs
    return pairs.select(_alone(table.fixed, table.seen_by_ns, pairs.one, pairs.other, stamp_ns))


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


def absorb(table: TrackTable, kept: int, dropped: int) -> None:
    """Give a track what is known of its duplicate."""
    newer = table.seen_by_ns[dropped] > table.seen_by_ns[kept]
    table.local_id[kept] = np.where(newer, table.local_id[dropped], table.local_id[kept])
    table.seen_by_ns[kept] = np.maximum(table.seen_by_ns[kept], table.seen_by_ns[dropped])
    for name in ('seen_ns', 'kept_ns', 'evidence'):
        values = getattr(table, name)
        values[kept] = max(values[kept], values[dropped])
    if table.confirmed[dropped]:
        table.missed[kept] = min(table.missed[kept], table.missed[dropped])
    table.cameras[kept] |= table.cameras[dropped]
    table.shown_by[kept] |= table.shown_by[dropped]
    if np.trace(table.covariance[dropped]) < np.trace(table.covariance[kept]):
        for name in ('mean', 'covariance', 'mode_probability', 'mode_mean', 'mode_covariance'):
            getattr(table, name)[kept] = getattr(table, name)[dropped]
    if not table.template[kept].any():
        table.template[kept] = table.template[dropped]
    own, other = table.extent[kept], table.extent[dropped]
    table.extent[kept] = np.where(np.isnan(own), other, own)
    table.previous_id[kept] = table.track_id[dropped]
