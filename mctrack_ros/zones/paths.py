"""Crossings and stays of whole paths at once: what `ZoneEngine` finds tick after tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import PAUSE_NS
from mctrack_ros.zones.shapes import Line, Zone, Zones
from mctrack_ros.zones.sides import Look, Sides

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

NEVER_NS = np.iinfo(np.int64).max
_AT_ONCE = 50_000
"""Rows that are compared with all edges of a zone or line at a time: more need memory."""


@dataclass(frozen=True, eq=False, slots=True)
class Paths:
    """
    Where lives were, one row each, in any order; of a life at most one row a tick.

    Attributes
    ----------
    life : (n,) int array
        Whose rows they are.
    stamp_ns : (n,) int array
        When, ns.
    position : (n, 2) array
        Where, m.
    covariance : (n, 2, 2) array
        Of that, m².

    """

    life: Ints
    stamp_ns: Ints
    position: Floats
    covariance: Floats

    def ordered(self) -> Paths:
        """Return the rows life by life, in the order of time."""
        order = np.lexsort([self.stamp_ns, self.life])
        position, covariance = self.position[order], self.covariance[order]
        return Paths(self.life[order], self.stamp_ns[order], position, covariance)


@dataclass(frozen=True, eq=False, slots=True)
class Passages:
    """
    Crossings of a line, in the order of time.

    Attributes
    ----------
    life : (k,) int array
        Who crosses.
    stamp_ns : (k,) int array
        When that is decided, ns.
    way : (k,) int8 array
        1 to the left of the line, -1 to its right.

    """

    life: Ints
    stamp_ns: Ints
    way: NDArray[np.int8]


@dataclass(frozen=True, eq=False, slots=True)
class Stays:
    """
    Stays in a zone, in the order of their beginnings.

    Attributes
    ----------
    life : (k,) int array
        Who is inside.
    entered_ns, left_ns : (k,) int array
        When it is decided that they are, and that they are no more, ns; `NEVER_NS`: not yet.

    """

    life: Ints
    entered_ns: Ints
    left_ns: Ints


def passages(line: Line, paths: Paths) -> Passages:
    """Return who crosses a line; see `ZoneEngine` for the rule."""
    sides, paths = Sides(Zones(lines=(line,))), paths.ordered()
    is_sure, _, squared = _looked(sides, paths)
    sure = np.flatnonzero(is_sure)
    begin, end = sure[:-1], sure[1:]
    step = np.square(paths.position[end] - paths.position[begin]).sum(axis=1)
    near = (paths.life[begin] == paths.life[end]) & (step > squared[end])
    begin, end = begin[near], end[near]
    at, to = paths.position[begin], paths.position[end]
    way = sides.crossed(at, to, np.zeros(len(begin), np.intp))
    rows, way = end[way != 0], way[way != 0]
    order = np.argsort(paths.stamp_ns[rows], kind='stable')
    return Passages(paths.life[rows][order], paths.stamp_ns[rows][order], way[order])


def stays(zone: Zone, paths: Paths, ticks_ns: Ints) -> Stays:
    """
    Return who is in a zone, from when to when; see `ZoneEngine` for the rule.

    Parameters
    ----------
    zone : Zone
        In the coordinates of the paths.
    paths : Paths
        Of all lives.
    ticks_ns : (m,) int array
        Stamps of all ticks, ascending, ns: who is in none of those after a pause is away.

    """
    paths = paths.ordered()
    is_sure, inside, _ = _looked(Sides(Zones((zone,))), paths)
    life, stamp_ns = paths.life, paths.stamp_ns
    after = np.searchsorted(ticks_ns, stamp_ns + PAUSE_NS, side='right')
    away_ns = np.append(ticks_ns, NEVER_NS)[after]
    is_last = np.ones(len(life), bool)
    is_last[:-1] = (life[1:] != life[:-1]) | (stamp_ns[1:] > away_ns[:-1])
    held, held_before = _held(is_sure, inside, is_last)
    entered = np.flatnonzero(held & ~held_before)
    left = np.flatnonzero((held_before & ~held) | (held & is_last))
    # who is inside at his last row is away from the tick after the pause on
    left_ns = np.where(held[left], away_ns[left], stamp_ns[left])
    order = np.argsort(stamp_ns[entered], kind='stable')
    return Stays(life[entered][order], stamp_ns[entered][order], left_ns[order])


def _held(is_sure: Flags, inside: Flags, is_last: Flags) -> tuple[Flags, Flags]:
    """Return who is inside at each row (n,), as at the last sure one, and at the row before."""
    is_first = np.ones(len(is_last), bool)
    is_first[1:] = is_last[:-1]
    rows = np.arange(len(is_last))
    began = np.maximum.accumulate(np.where(is_first, rows, 0))
    decided = np.maximum.accumulate(np.where(is_sure, rows, -1))
    held = (decided >= began) & inside[decided]
    before = np.zeros(len(held), bool)
    before[1:] = held[:-1] & ~is_first[1:]
    return held, before


def _looked(sides: Sides, paths: Paths) -> tuple[Flags, Flags, Floats]:
    """Return where it is decided on which side rows are, whether inside, and squared distances."""
    parts: list[Look] = []
    for begin in range(0, len(paths.life), _AT_ONCE):
        part = slice(begin, begin + _AT_ONCE)
        parts.append(sides.look(paths.position[part], paths.covariance[part]))
    none = sides.look(np.zeros((0, 2)), np.zeros((0, 2, 2)))
    is_sure = np.concatenate([each.is_sure for each in (*parts, none)])[:, 0]
    inside = np.concatenate([each.inside for each in (*parts, none)])
    squared = np.concatenate([each.squared for each in (*parts, none)])[:, 0]
    return is_sure, inside[:, 0] if sides.zones else np.zeros(len(is_sure), bool), squared
