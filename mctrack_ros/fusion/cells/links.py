"""Which target each track of a cell is: kept as long as nothing speaks against it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.solvers import ASSOCIATORS
from mctrack_ros.fusion.association.solvers.pairs import Pairs
from mctrack_ros.fusion.cells.intersection import intersection
from mctrack_ros.fusion.cells.likelihood import colour_costs, costs
from mctrack_ros.fusion.cells.members import CellTracks
from mctrack_ros.fusion.columns import NEVER_NS
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Key = tuple[int, int]

HOLD = 8.0
"""What it is worth that a cell's id goes on, -2 log: the strongest evidence that there is."""
MEMORY_S = 0.5
"""Over so long the evidence of a pair is averaged, s: errors of a filter last so long."""
DECIDE_S = 0.4
"""Time that a cell must know somebody near another's target before it is decided who he is, s."""
LIMIT = 40.0
"""A cost counts for so much at most, either way: one bad state decides nothing."""
JUMP = 13.8
"""Squared Mahalanobis distance beyond which a track was not where it had led: 99.9 %."""
DOUBTED_S = 2.0
"""For so long after that a cell is the first to be wrong, s."""
REACH_M, SIGMAS = 3.0, 4.0
"""Pairs farther apart than this, and standard deviations of the target's place, are none."""
OPEN = 0
"""It is not decided yet which target it is."""


@dataclass(slots=True)
class Link:
    """
    What is known of one track of a cell.

    Attributes
    ----------
    target : int
        Id of the target that it is; `OPEN`.
    known_ns : int
        Since when it is known, or known to be another than was thought, ns.
    since_ns : int
        Since when it is that target, ns.
    state : (4,) array, optional
        Where it was at the last tick, and how it moved: x, y, vx, vy; m and m/s.
    jumped_ns : int
        When it last was not where that led, ns.

    """

    target: int
    known_ns: int
    since_ns: int
    state: Floats | None = None
    jumped_ns: int = NEVER_NS


class Links:
    """
    The links of all cells' tracks to targets, by cell and the cell's id.

    A track that is linked stays so while the other cells that see the target agree, within what
    a bias between cells explains; one that is not linked goes to the target that it most likely
    is, all of a cell's together; where it is near one that others see, after `DECIDE_S`.
    """

    def __init__(self) -> None:
        self.known: dict[Key, Link] = {}
        self._evidence: dict[tuple[Key, int], float] = {}

    def target(self, key: Key) -> int:
        """Return the target that a cell's track is; `OPEN`."""
        link = self.known.get(key)
        return OPEN if link is None else link.target

    def targets(self, keys: list[Key]) -> Indices:
        """Return the targets, (m,), of cells' tracks."""
        return np.array([self.target(key) for key in keys], np.intp)

    def put(self, key: Key, target: int, stamp_ns: int) -> None:
        """Link a cell's track to a target."""
        link = self.known.setdefault(key, Link(target, stamp_ns, stamp_ns))
        if link.target != target:
            link.target, link.since_ns = target, stamp_ns

    def rename(self, old: int, new: int) -> None:
        """Let all that are one target be another one."""
        for link in self.known.values():
            if link.target == old:
                link.target = new

    def keep(self, keys: list[Key], targets: list[int]) -> None:
        """Forget the tracks that neither a cell has now nor a living target had."""
        now, living = set(keys), set(targets)
        self.known = {
            key: link for key, link in self.known.items() if key in now or link.target in living
        }

    def step(self, members: CellTracks, table: TrackTable, stamp_ns: int, seconds: float) -> None:
        """
        Decide which targets the tracks of a tick are; who is new stays open and `is_due`.

        Parameters
        ----------
        members : CellTracks
            All tracks.
        table : TrackTable
            The targets, predicted.
        stamp_ns : int
            The tick's stamp, ns.
        seconds : float
            Since the last tick, s.

        """
        keys = members.keys
        for key in keys:
            self.known.setdefault(key, Link(OPEN, stamp_ns, stamp_ns))
        self._follow(members, stamp_ns, seconds)
        row_of = {int(name): row for row, name in enumerate(table.track_id.tolist())}
        row = np.array([row_of.get(self.target(key), -1) for key in keys], np.intp)
        for key, own in zip(keys, row.tolist()):
            if own < 0:
                self.known[key].target = OPEN
        pairs = _candidates(members, table, row)
        cost = self._averaged(members, table, pairs, row, seconds)
        self._doubtful = {keys[i] for i in pairs[0][cost < LIMIT / 2].tolist()}
        chosen = self._assigned(members, row, pairs, cost, stamp_ns)
        settled = self._settled(members, table, row, chosen, stamp_ns)
        for key, before, now in zip(keys, row.tolist(), settled.tolist()):
            if now != before:
                self.put(key, int(table.track_id[now]) if now >= 0 else OPEN, stamp_ns)
                if now < 0:
                    self.known[key].known_ns = stamp_ns  # who it is now, is decided anew

    def is_due(self, key: Key, stamp_ns: int) -> bool:
        """Tell whether one that is open is somebody new."""
        known_s = (stamp_ns - self.known[key].known_ns) * 1e-9
        return key not in self._doubtful or known_s >= DECIDE_S

    def _averaged(
        self,
        members: CellTracks,
        table: TrackTable,
        pairs: tuple[Indices, Indices],
        row: Indices,
        seconds: float,
    ) -> Floats:
        """Return the costs, (k,), of pairs, averaged over `MEMORY_S`."""
        who, whom = pairs
        if not len(who):
            self._evidence.clear()
            return np.zeros(0)
        expected, spread = _by_others(members, table, pairs, row)
        colours = np.stack([members.template[who], table.template[whom]])
        state = members.mean[who], members.covariance[who]
        now = np.clip(costs(*state, colours, expected, spread), -LIMIT, LIMIT)
        share, keys = 1.0 - np.exp(-seconds / MEMORY_S), members.keys
        names = [
            (keys[i], target) for i, target in zip(who.tolist(), table.track_id[whom].tolist())
        ]
        before = np.array([self._evidence.get(name, np.nan) for name in names])
        cost = np.where(np.isnan(before), now, before + share * (now - before))
        self._evidence = dict(zip(names, cost.tolist()))
        return np.asarray(cost)

    def _assigned(
        self,
        members: CellTracks,
        row: Indices,
        pairs: tuple[Indices, Indices],
        cost: Floats,
        stamp_ns: int,
    ) -> Indices:
        """Return which row of the targets each track is, (m,), -1: none, all of a cell at once."""
        who, whom = pairs
        is_own = row[who] == whom
        is_open = [self.known[key].target == OPEN for key in members.keys]
        is_due = [self.is_due(key, stamp_ns) for key in members.keys]
        waits = np.array(is_open, bool) & ~np.array(is_due, bool)
        kept = is_own | ~waits[who]
        alone = np.setdiff1d(np.flatnonzero(row >= 0), who[is_own])
        detection = np.concatenate([who[kept], alone])
        target = np.concatenate([whom[kept], row[alone]])
        worth = np.concatenate([cost[kept] - HOLD * is_own[kept], np.full(len(alone), -LIMIT)])
        taken, whose = _best_pairs(detection, target, worth, members.cell[detection])
        chosen = np.full(len(members), -1, np.intp)
        chosen[taken] = whose
        return chosen

    def _settled(
        self, members: CellTracks, table: TrackTable, row: Indices, chosen: Indices, stamp_ns: int
    ) -> Indices:
        """
        Return which row of the targets each track is in the end, (m,), -1: none.

        Where the tracks of several cells would leave the same targets, one cell is wrong and the
        others are right: the tracks of the cell that is most suspect leave.
        """
        moves = np.flatnonzero((row >= 0) & (chosen != row))
        settled = chosen.copy()
        settled[moves] = row[moves]
        suspicion = self._suspicion(members, table, row, moves, stamp_ns)
        touched: set[int] = set()
        for part in _connected([(row[i], chosen[i]) for i in moves.tolist()]):
            worst = members.cell[moves[max(part, key=suspicion.__getitem__)]]
            for i in moves[part][members.cell[moves[part]] == worst].tolist():
                settled[i] = chosen[i]
                touched |= {int(row[i]), int(chosen[i])}
        taken = {(members.cell[i], settled[i]) for i in np.flatnonzero(row >= 0).tolist()}
        for i in np.flatnonzero((row < 0) & (settled >= 0)).tolist():
            if (members.cell[i], settled[i]) in taken:
                settled[i] = -1
        names = {int(table.track_id[each]) for each in touched if each >= 0}
        self._evidence = {
            pair: cost for pair, cost in self._evidence.items() if pair[1] not in names
        }
        return settled

    def _suspicion(
        self, members: CellTracks, table: TrackTable, row: Indices, moves: Indices, stamp_ns: int
    ) -> list[tuple[bool, float, int, int]]:
        """Return how suspect tracks (k,) are: who jumped, who looks otherwise, who came last."""
        unlike = np.round(colour_costs(members.template[moves], table.template[row[moves]]))
        links = [self.known[members.keys[i]] for i in moves.tolist()]
        return [
            (stamp_ns - link.jumped_ns < DOUBTED_S * 1e9, colour, link.since_ns, cell)
            for link, colour, cell in zip(links, unlike.tolist(), members.cell[moves].tolist())
        ]

    def _follow(self, members: CellTracks, stamp_ns: int, seconds: float) -> None:
        """Note which tracks are not where they led at the last tick."""
        links = [self.known[key] for key in members.keys]
        states = [mean if link.state is None else link.state
                  for link, mean in zip(links, members.mean)]  # fmt: skip
        before = np.array(states).reshape(-1, 4)
        gap = members.mean[:, :2] - before[:, :2] - seconds * before[:, 2:]
        spread = np.linalg.inv(members.covariance[:, :2, :2])
        jumped = (gap[:, None] @ spread @ gap[:, :, None])[:, 0, 0] > JUMP
        for link, mean, has_jumped in zip(links, members.mean, jumped.tolist()):
            if has_jumped and link.state is not None:
                link.jumped_ns = stamp_ns
            link.state = mean


def _connected(moves: list[tuple[int, int]]) -> list[list[int]]:
    """Return which moves (k,), from target to target, have targets in common, directly or not."""
    parts: list[tuple[set[int], list[int]]] = []
    for index, move in enumerate(moves):
        own = {each for each in move if each >= 0}
        joined = [part for part in parts if part[0] & own]
        parts = [part for part in parts if not part[0] & own]
        targets, members = own.union(*(part[0] for part in joined)), [index]
        parts.append((targets, [each for part in joined for each in part[1]] + members))
    return [sorted(part[1]) for part in parts]


def _seen_by(members: CellTracks, row: Indices, count: int, mask: NDArray[np.bool_]) -> Indices:
    """Return the bits of the cells that have each target, (n,), of some tracks."""
    bits = np.zeros(count, np.uint32)
    np.bitwise_or.at(bits, row[mask], members.bit[mask])
    return bits.astype(np.intp)


def _candidates(members: CellTracks, table: TrackTable, row: Indices) -> tuple[Indices, Indices]:
    """
    Return the pairs of a track and a target (k,) of which something is known.

    That is, where other cells see the target, or none has it. A track whose target no other cell
    sees stays with it.
    """
    linked = row >= 0
    seen = _seen_by(members, row, len(table), linked & members.is_seen)
    had = _seen_by(members, row, len(table), linked)
    own = members.bit.astype(np.intp)[:, None]
    by_others = (seen & ~own) != 0
    is_lost = (had & own == 0) & (seen == 0)
    is_sole = np.zeros(len(members), bool)
    is_sole[linked] = ~by_others[linked, row[linked]]
    gap = members.mean[:, None, :2] - table.mean[None, :, :2]
    spread = np.sqrt(np.trace(table.covariance[:, :2, :2], axis1=1, axis2=2))
    near = (gap**2).sum(axis=2) < (REACH_M + SIGMAS * spread) ** 2
    is_own = np.zeros(near.shape, bool)
    is_own[linked, row[linked]] = True
    pairs = (by_others & (near | is_own)) | (is_lost & near)
    return pairs_of(pairs & (members.is_seen & ~is_sole)[:, None])


def pairs_of(mask: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return rows and columns, (k,) each, of a mask."""
    one, other = np.nonzero(mask)
    return one, other


def _by_others(
    members: CellTracks, table: TrackTable, pairs: tuple[Indices, Indices], row: Indices
) -> tuple[Floats, Floats]:
    """Return where other cells than a track's own see the target of each pair, (k, 4), and how."""
    who, whom = pairs
    mean, covariance = table.mean[whom], table.covariance[whom]
    asked, part = np.unique(
        np.column_stack([whom, members.cell[who]]), axis=0, return_inverse=True
    )
    rows: list[int] = []
    parts: list[int] = []
    for index, (target, cell) in enumerate(asked.tolist()):
        others = np.flatnonzero((row == target) & members.is_seen & (members.cell != cell))
        rows += others.tolist()
        parts += [index] * len(others)
    answered, number = np.unique(np.array(parts, np.intp), return_inverse=True)
    if len(answered):
        state = members.mean[rows], members.covariance[rows]
        known = intersection(*state, number, len(answered))
        place = np.full(len(asked), -1)
        place[answered] = np.arange(len(answered))
        place = place[part]
        placed = place >= 0
        mean[placed], covariance[placed] = known[0][place[placed]], known[1][place[placed]]
    return mean, covariance


def _best_pairs(
    detection: Indices, target: Indices, worth: Floats, cell: Indices
) -> tuple[Indices, Indices]:
    """Return the pairs, (k,) tracks and targets, of the best assignment of all cells at once."""
    order = np.lexsort((detection, target, cell))
    detection, target, cell = (each[order] for each in (detection, target, cell))
    is_new = np.ones(len(order), bool)
    is_new[1:] = (np.diff(cell) != 0) | (np.diff(target) != 0)
    slot = np.cumsum(is_new) - 1
    pairs = Pairs(
        track=np.ascontiguousarray(target, np.int64),
        detection=np.ascontiguousarray(detection, np.int64),
        slot=np.ascontiguousarray(slot, np.int64),
        likelihood=np.exp(-worth[order] / 2),
        image=np.ascontiguousarray(cell, np.int64),
    )
    taken = ASSOCIATORS['gnn']().probabilities(pairs) > 0
    return detection[taken], target[taken]
