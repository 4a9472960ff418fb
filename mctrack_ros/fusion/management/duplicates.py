"""When two tracks are of one target."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.neighbours import is_near
from mctrack_ros.fusion.table import TRACKS, TrackTable

MERGE_S = 1.7
"""Time that two tracks are in one place before they are one, s: by 24 development crowds."""
BOTH_SEEN_LOSS = 5.0
"""An image that shows both takes away what so many others in one place add."""
ENDING = 0.5
"""Where either would end, so much of the time is enough: the other has taken all its support."""
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


class DuplicateWatch:
    """
    Notices two tracks that follow one target: near for a while, hardly separated by a camera.

    Parameters
    ----------
    seconds : float
        For how long, if they are in one place, s.

    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._doubts_s: dict[tuple[int, int], float] = {}

    def clear(self) -> None:
        """Forget all pairs: none are near."""
        self._doubts_s.clear()

    def find(self, table: TrackTable, pairs: ClosePairs, over: Mask) -> list[tuple[int, int]]:
        """
        Add a tick; return which pairs of rows are one target by now: (kept, dropped).

        Of the tracks, (n,) are over.
        """
        before, self._doubts_s = self._doubts_s, {}
        chosen: list[tuple[int, int]] = []
        used: set[int] = set()
        one, other = pairs.one, pairs.other
        names = zip(table.track_id[one].tolist(), table.track_id[other].tolist())
        columns = one.tolist(), other.tolist(), pairs.gain.tolist(), pairs.reported.tolist()
        for pair, first, second, gain, reported in zip(names, *columns):
            seconds = before[pair] + gain if pair in before else 0.0
            if reported and seconds <= 0.0:
                continue  # nothing is left: they begin anew
            self._doubts_s[pair] = seconds
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
    gain = np.empty(len(one))
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
            gain[pair] = -BOTH_SEEN_LOSS * seconds
    left = np.flatnonzero(close)
    first, second = one[left], other[left]
    return first, second, gain[left], reported[left], (group[first] | group[second]) != 0
