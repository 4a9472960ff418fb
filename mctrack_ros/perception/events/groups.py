"""Which local tracks are one group, and when groups form and part (Definition 6, E5, E3)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_2D, INTS_1D, INTS_2D, compiled
from mctrack_ros.config import parameter

Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
MOMENTS = types.Array(types.i8, 2, 'C')


@dataclass(frozen=True)
class GroupConfig:
    """Parameters of `Groups`."""

    part_s: float = parameter(
        0.4, 'how long tracks must be apart before a split is reported [s]', minimum=0.0
    )
    stable_s: float = parameter(
        0.4, 'how long a track must be alone before it is stable (E6) [s]', minimum=0.0
    )


@dataclass(frozen=True, slots=True)
class Change:
    """
    A part that joined a group or left it.

    Attributes
    ----------
    merged : bool
        Joined (E5); else left (E3).
    part : tuple of int
        Local ids of the part, ascending.
    rest : tuple of int
        Local ids of the others that are, or were, in the group.

    """

    merged: bool
    part: tuple[int, ...]
    rest: tuple[int, ...]


class Groups:
    """
    Tracks in one part of the foreground touch; those that do, or did a moment ago, are a group.

    A group is what is connected by touching (groups of groups are groups), so its members part
    only when none of them has touched any of the others for some time. A track that is not seen
    stays as it was. Every event is of one part; the largest part stays the group.

    Parameters
    ----------
    config : GroupConfig
        Parameters.

    """

    def __init__(self, config: GroupConfig) -> None:
        self._hold_ns = round(config.part_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget all groups."""
        self._id: Ints = np.zeros(0, np.int64)
        self._group: Ints = np.zeros(0, np.int64)
        self._touched_ns: Ints = np.zeros((0, 0), np.int64)
        self._joined: Booleans = np.zeros((0, 0), np.bool_)
        self._last_ns = 0

    def rename(self, changes: dict[int, int]) -> None:
        """Let tracks go on under other ids, old to new, all at once."""
        if changes.keys().isdisjoint(self._id.tolist()):
            return
        ids = np.array([changes.get(one, one) for one in self._id.tolist()], np.int64)
        if len(np.unique(ids)) < len(ids):
            return  # two would be one: the new name is in view already
        order = np.argsort(ids)
        self._id, self._group = ids[order], self._group[order]
        self._touched_ns = np.ascontiguousarray(self._touched_ns[np.ix_(order, order)])
        self._joined = np.ascontiguousarray(self._joined[np.ix_(order, order)])

    def members(self) -> list[tuple[int, ...]]:
        """Return the local ids, ascending, of each group of several."""
        counts = np.bincount(self._group)
        several = np.flatnonzero(counts > 1).tolist()
        return [tuple(self._id[self._group == number].tolist()) for number in several]

    def sizes(self) -> Ints:
        """Return how many are in the group of each of those last given, (n,), himself too."""
        return np.bincount(self._group)[self._group]

    def step(
        self, local_id: Ints, part: Ints, stamp_ns: int, quiet: Booleans | None = None
    ) -> list[Change]:
        """
        Tell what changed.

        Parameters
        ----------
        local_id : (n,) int64 array
            Confirmed tracks, ascending.
        part : (n,) int64 array
            The part of the foreground each is in (see `contacts`); -1: not seen.
        stamp_ns : int
            Time of the image, ns.
        quiet : (n,) bool array, optional
            Who, if not known before, was there all the same: has always been in the group in
            which he turns up.

        """
        same = np.array_equal(local_id, self._id)
        known = np.ones(len(local_id), np.bool_) if same else self._follow(local_id)
        joined = self._touch(part, stamp_ns)
        if same and np.array_equal(joined, self._joined):
            return []
        was, self._joined = self._group, joined
        self._group = _connected(joined)
        if quiet is not None:
            was = self._settled(was, quiet & ~known)
        merged = _parts(local_id, self._group, was)
        parted = _parts(local_id[known], was[known], self._group[known])
        return [Change(True, *pair) for pair in merged] + [Change(False, *pair) for pair in parted]

    def _follow(self, local_id: Ints) -> Booleans:
        """Carry over what is known of tracks that live on; return which. New ones are alone."""
        known, self._group, self._touched_ns = _carried_over(
            local_id, self._id, self._group, self._touched_ns, -self._hold_ns - 1
        )
        self._id = local_id
        return known

    def _settled(self, was: Ints, quiet: Booleans) -> Ints:
        """Return former groups in which quiet ones were with most of those they touch."""
        was = was.copy()
        for row in np.flatnonzero(quiet).tolist():
            mates = was[(self._group == self._group[row]) & ~quiet]
            if len(mates):
                was[row] = np.bincount(mates).argmax()
        return was

    def _touch(self, part: Ints, stamp_ns: int) -> Booleans:
        """Note who touches; return who touches or did a moment ago."""
        since_ns, self._last_ns = stamp_ns - self._last_ns, stamp_ns
        return _joined(self._touched_ns, part, stamp_ns, since_ns, max(self._hold_ns, 1))


@compiled(
    types.Tuple([types.b1[::1], types.i8[::1], types.i8[:, ::1]])(
        INTS_1D, INTS_1D, INTS_1D, INTS_2D, types.i8
    )
)
def _carried_over(
    local_id: Ints, old_id: Ints, group: Ints, touched_ns: Ints, never_ns: int
) -> tuple[Booleans, Ints, Ints]:
    """Return which tracks are known, and groups and last times of all; both ids ascend."""
    count, old, free = len(local_id), 0, 1
    for row in range(len(group)):
        free = max(free, group[row] + 1)
    known, groups = np.zeros(count, np.bool_), np.empty(count, np.int64)
    place, touched = np.empty(count, np.int64), np.empty((count, count), np.int64)
    for row in range(count):
        while old < len(old_id) and old_id[old] < local_id[row]:
            old += 1
        known[row], place[row] = old < len(old_id) and old_id[old] == local_id[row], old
        groups[row] = group[old] if known[row] else free + row
    for row in range(count):
        for column in range(count):
            both = known[row] and known[column]
            touched[row, column] = touched_ns[place[row], place[column]] if both else never_ns
    return known, groups, touched


@compiled(types.b1[:, ::1](MOMENTS, INTS_1D, types.i8, types.i8, types.i8))
def _joined(touched_ns: Ints, part: Ints, stamp_ns: int, since_ns: int, hold_ns: int) -> Booleans:
    """Write who touches into the (n, n) last times; return who touches or did a moment ago."""
    joined = np.empty(touched_ns.shape, np.bool_)
    for row in range(len(part)):
        for column in range(len(part)):
            if part[row] < 0 or part[column] < 0:
                touched_ns[row, column] += since_ns
            elif part[row] == part[column]:
                touched_ns[row, column] = stamp_ns
            recent = stamp_ns - touched_ns[row, column] < hold_ns
            joined[row, column] = recent or row == column
    return joined


@compiled(types.i8[::1](BOOLS_2D))
def _connected(joined: Booleans) -> Ints:
    """Return (n,) numbers of the parts of a graph that are connected, by first node."""
    label, waiting = np.full(len(joined), -1), np.empty(len(joined), np.int64)
    count = 0
    for start in range(len(joined)):
        if label[start] >= 0:
            continue
        label[start], waiting[0], most = count, start, 1
        while most:
            most -= 1
            node = waiting[most]
            for other in range(len(joined)):
                if joined[node, other] and label[other] < 0:
                    label[other], waiting[most] = count, other
                    most += 1
        count += 1
    return label


def _parts(
    local_id: Ints, whole: Ints, part: Ints
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Return every part of a whole but the largest, with the rest of the whole."""
    labels = list(zip(whole.tolist(), part.tolist()))
    if len(set(labels)) == len(set(whole.tolist())):
        return []
    members: dict[int, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for one, (number, label) in zip(local_id.tolist(), labels):
        members[number][label].append(one)
    found = []
    for _, parts in sorted(members.items()):
        smaller = sorted(sorted(parts), key=lambda label: -len(parts[label]))[1:]
        for leaving in (parts[label] for label in smaller):
            rest = {one for each in parts.values() for one in each}.difference(leaving)
            found.append((tuple(leaving), tuple(sorted(rest))))
    return found
