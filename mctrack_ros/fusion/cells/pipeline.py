"""Fusion of cells: one step a tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import logit

from mctrack_ros.fusion.cells.config import CellsConfig
from mctrack_ros.fusion.cells.corrections import corrected
from mctrack_ros.fusion.cells.intersection import intersection
from mctrack_ros.fusion.cells.likelihood import costs
from mctrack_ros.fusion.cells.links import OPEN, Links
from mctrack_ros.fusion.cells.members import NO_CELL_TRACKS, CellTracks, cell_tracks_of
from mctrack_ros.fusion.cells.report import CellReport
from mctrack_ros.fusion.joint_tracker.output import FusionOutput, feedback_of, tracks_of
from mctrack_ros.fusion.management.duplicates import MERGE_S
from mctrack_ros.fusion.management.event_log import EventLog
from mctrack_ros.fusion.management.manager import LARGEST_ID
from mctrack_ros.fusion.motion.models import ConstantVelocity
from mctrack_ros.fusion.neighbours import near_pairs
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import MAX_CAMERAS, EventCode, Feedback, RowsTick, starts_anew

if TYPE_CHECKING:
    from mctrack_ros.fusion.explain.recorder import DecisionRecorder

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

ACCELERATION_DENSITY = 2.0
"""As cells have it, unless told, m²/s³."""
TEMPLATE_S = 8.0
"""Time constant of a target's colours, s: it follows from cell to cell, not single images."""
JOIN_M = 3.0
"""Two targets farther apart are not the same, m."""
SURE = 1e-6
"""A score counts as this far from 0 and 1 at least."""


class CellTracker:
    """
    Tracks the targets of a whole site from the tracks of its cells.

    A cell is a fusion node with cameras of its own. A target is whatever its linked tracks say,
    combined by covariance intersection, as cells may share what they know; nothing is filtered
    again. Who a cell's track is, is decided once and kept while its id goes on; see `Links`.

    Parameters
    ----------
    config : CellsConfig
        Parameters.
    cells : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first target; those of later ones ascend from it.

    Raises
    ------
    ValueError
        If there are too many cells or a name occurs twice.

    """

    bias = None

    def __init__(self, config: CellsConfig, cells: tuple[str, ...], first_id: int = 1) -> None:
        if len(cells) > MAX_CAMERAS or len(set(cells)) != len(cells):
            raise ValueError(f'cells are {cells!r}, expected at most {MAX_CAMERAS}, distinct')
        self._config, self._cells = config, cells
        self._motion = ConstantVelocity(ACCELERATION_DENSITY)
        self.next_id = first_id
        self._begin_anew(None)

    def _begin_anew(self, stamp_ns: int | None) -> None:
        self._table = TrackTable.blank(0, len(self._cells))
        self._reports: dict[int, CellTracks] = {}
        self._heard_ns: dict[int, int] = {}
        self._links = Links()
        self._close_s: dict[tuple[int, int], float] = {}
        self._stamp_ns = stamp_ns

    def step(
        self, tick: RowsTick[CellReport], recorder: DecisionRecorder | None = None
    ) -> FusionOutput:
        """
        Process one tick; see `JointTracker.step`.

        A cell without a new report counts with its last one, predicted, until it is silent for
        `batching.camera_timeout`.

        Raises
        ------
        ValueError
            If a cell is not known or the tick's stamp steps back by less than a second.
        OverflowError
            If there may be no ids left for who begins.

        """
        events = EventLog()
        ended, seconds = self._predict(tick.stamp_ns, events)
        ended = ended.extended(self._hear(tick, events))
        reports = [self._reports[cell] for cell in sorted(self._reports)]
        members = CellTracks.joined([NO_CELL_TRACKS, *reports])
        members = members.predicted(tick.stamp_ns, ACCELERATION_DENSITY)
        self._links.step(members, self._table, tick.stamp_ns, seconds)
        self._begin(members, events)
        self._fuse(members, seconds)
        ended = ended.extended(self._join(members, seconds, events))
        self._links.keep(members.keys, self._table.track_id.tolist())
        tracks = tracks_of(self._table, self._is_reported(), ended, tick.stamp_ns)
        return FusionOutput(tracks, events.events(tick.stamp_ns))

    def feedback(self) -> Feedback:
        """Return all published targets: so a site can be a cell of a larger one."""
        if self._stamp_ns is None:
            return Feedback.build(0)
        return feedback_of(self._table.select(self._is_reported()), self._stamp_ns)

    def _predict(self, stamp_ns: int, events: EventLog) -> tuple[TrackTable, float]:
        """Predict the targets; return those that are over, and the time since the last tick, s."""
        period, last_ns = self._config.batching.period, self._stamp_ns
        if starts_anew(stamp_ns, last_ns):
            ended = self._remove(np.ones(len(self._table), bool), events)
            self._begin_anew(stamp_ns)
            return ended, period
        seconds = period if last_ns is None else (stamp_ns - last_ns) * 1e-9
        if seconds < 0:
            raise ValueError(f'the tick is stamped {stamp_ns}, expected at least {last_ns}')
        self._stamp_ns = stamp_ns
        self._motion.predict(self._table, seconds)
        self._table.previous_id[:] = 0
        return self._remove(self._unseen_s() > self._config.lost_time, events), seconds

    def _hear(self, tick: RowsTick[CellReport], events: EventLog) -> TrackTable:
        """Take the cells' reports and corrections; return the targets that these have ended."""
        ended = TrackTable.blank(0, len(self._cells))
        for message in tick.messages:
            if message.camera not in self._cells:
                known = list(self._cells)
                raise ValueError(f'cell is {message.camera!r}, expected one of {known}')
            cell, report = self._cells.index(message.camera), message.rows
            changes = report.feedback.corrections()
            if changes:
                renamed = corrected(self._links, self._table, cell, changes, tick.stamp_ns)
                ended = ended.extended(self._rename(renamed, events))
            self._reports[cell] = cell_tracks_of(cell, report, self._config.cell_sigma)
            self._heard_ns[cell] = report.stamp_ns
        limit_ns = tick.stamp_ns - round(self._config.batching.patience * 1e9)
        for cell in [cell for cell, heard_ns in self._heard_ns.items() if heard_ns < limit_ns]:
            del self._reports[cell], self._heard_ns[cell]
        return ended

    def _begin(self, members: CellTracks, events: EventLog) -> None:
        """Begin targets of tracks that are nobody known, one after the other: cells share them."""
        target = self._links.targets(members.keys)
        begun: list[int] = []
        for index in np.flatnonzero((target == OPEN) & members.is_seen).tolist():
            key = members.keys[index]
            if not self._links.is_due(key, self._stamp_ns or 0):
                continue
            other = self._among(members, index, begun, target)
            if other < 0:
                begun.append(index)
            target[index] = self.next_id if other < 0 else target[other]
            self.next_id += other < 0
            self._links.put(key, int(target[index]), self._stamp_ns or 0)
        if self.next_id > LARGEST_ID:
            raise OverflowError(f'ids have run out: the next is {self.next_id}; start anew')
        fresh = TrackTable.blank(len(begun), len(self._cells))
        fresh.track_id, fresh.confirmed = target[begun], True
        fresh.mean, fresh.covariance = members.mean[begun], members.covariance[begun]
        fresh.first_ns, fresh.template = members.first_ns[begun], members.template[begun]
        fresh.evidence = logit(np.clip(members.score[begun], SURE, 1 - SURE))
        events.add_all(EventCode.NEW, fresh, np.ones(len(begun), bool))
        self._table = self._table.extended(fresh)

    def _among(self, members: CellTracks, index: int, begun: list[int], target: Indices) -> int:
        """Return which of those begun in this tick, by other cells, a track is; -1: none."""
        taken = target[(members.cell == members.cell[index]) & (target != OPEN)]
        others = [
            row
            for row in begun
            if target[row] not in taken and members.cell[row] != members.cell[index]
        ]
        if not others:
            return -1
        own = np.full(len(others), index)
        cost = costs(
            members.mean[own],
            members.covariance[own],
            np.stack([members.template[own], members.template[others]]),
            members.mean[others],
            members.covariance[others],
        )
        return others[int(cost.argmin())] if cost.min() < 0 else -1

    def _fuse(self, members: CellTracks, seconds: float) -> None:
        """Let every target be what the cells that see it say."""
        table, target = self._table, self._links.targets(members.keys)
        table.cameras[:], table.group[:] = 0, 0
        seen = np.flatnonzero(members.is_seen & (target != OPEN))
        if not len(seen):
            return
        row = np.searchsorted(table.track_id, target[seen])
        rows, part = np.unique(row, return_inverse=True)
        table.mean[rows], table.covariance[rows] = intersection(
            members.mean[seen], members.covariance[seen], part, len(rows)
        )
        table.seen_ns[rows] = table.kept_ns[rows] = self._stamp_ns or 0
        table.evidence[rows] = -np.inf
        _fuse_evidence(table, row, members, seen)
        _fuse_appearance(table, row, members, seen, seconds)
        _fuse_groups(table, row, members, seen)

    def _join(self, members: CellTracks, seconds: float, events: EventLog) -> TrackTable:
        """Join targets that different cells have long seen in one place; return the ended."""
        table, target = self._table, self._links.targets(members.keys)
        had = np.zeros(len(table), np.uint32)
        linked = target != OPEN
        np.bitwise_or.at(had, np.searchsorted(table.track_id, target[linked]), members.bit[linked])
        one, other = near_pairs(table.mean, JOIN_M)
        apart = (table.cameras[one] > 0) & (table.cameras[other] > 0)
        apart &= (had[one] & had[other]) == 0
        one, other = one[apart], other[apart]
        close_s: dict[tuple[int, int], float] = {}
        renamed: dict[int, int] = {}
        if len(one):
            cost = costs(
                table.mean[one],
                table.covariance[one],
                np.stack([table.template[one], table.template[other]]),
                table.mean[other],
                table.covariance[other],
            )
            names = zip(table.track_id[one].tolist(), table.track_id[other].tolist())
            for pair, each in zip(names, cost.tolist()):
                kept, dropped = min(pair), max(pair)
                since_s = self._close_s.get((kept, dropped), 0.0)
                since_s = max(since_s + (seconds if each < 0 else -seconds), 0.0)
                if since_s >= MERGE_S and not {kept, dropped} & (
                    renamed.keys() | set(renamed.values())
                ):
                    renamed[dropped] = kept
                elif since_s > 0.0:
                    close_s[kept, dropped] = since_s
        self._close_s = close_s
        for dropped, kept in renamed.items():
            self._links.rename(dropped, kept)
        return self._rename(renamed, events)

    def _rename(self, renamed: dict[int, int], events: EventLog) -> TrackTable:
        """Note the targets that turned out to be others, old to new; return those that end."""
        table = self._table
        for old, new in renamed.items():
            row, gone = np.searchsorted(table.track_id, (new, old)).tolist()
            table.previous_id[row] = old
            if table.seen_ns[gone] > table.seen_ns[row]:
                for column in ('mean', 'covariance', 'seen_ns', 'kept_ns', 'cameras'):
                    getattr(table, column)[row] = getattr(table, column)[gone]
            events.add(EventCode.CORRECTION, table, row, old_id=old)
        over = [old for old in renamed if old not in renamed.values()]
        return self._remove(np.isin(table.track_id, over), events)

    def _remove(self, mask: NDArray[np.bool_], events: EventLog) -> TrackTable:
        """Take targets out, note their exit, and return them."""
        removed = self._table.select(mask)
        events.add_all(EventCode.EXIT, removed, np.ones(len(removed), bool))
        self._table = self._table.select(~mask)
        return removed

    def _unseen_s(self) -> Floats:
        return np.asarray(((self._stamp_ns or 0) - self._table.seen_ns) * 1e-9)

    def _is_reported(self) -> NDArray[np.bool_]:
        least = 1.5 * self._config.batching.period
        return np.asarray(self._unseen_s() <= max(self._config.report_time, least))


def _fuse_evidence(table: TrackTable, row: Indices, members: CellTracks, seen: Indices) -> None:
    """Give targets, (k,) rows, the scores and cameras of what cells see of them, (k,) members."""
    score = logit(np.clip(members.score[seen], SURE, 1 - SURE))
    np.maximum.at(table.evidence, row, score)
    np.bitwise_or.at(table.cameras, row, members.bit[seen])
    np.minimum.at(table.first_ns, row, members.first_ns[seen])


def _fuse_appearance(
    table: TrackTable, row: Indices, members: CellTracks, seen: Indices, seconds: float
) -> None:
    """Give targets the class, extent and colours that cells see."""
    has_class = members.class_id[seen] > 0
    table.class_id[row[has_class]] = members.class_id[seen[has_class]]
    has_extent = np.isfinite(members.extent[seen]).all(axis=1)
    table.extent[row[has_extent]] = members.extent[seen[has_extent]]
    has_colours = members.template[seen].any(axis=1)
    own, colours = row[has_colours], members.template[seen[has_colours]]
    before = table.template[own]
    share = np.where(before.any(axis=1), min(seconds / TEMPLATE_S, 1.0), 1.0)
    table.template[own] = before + share[:, None] * (colours - before)


def _fuse_groups(table: TrackTable, row: Indices, members: CellTracks, seen: Indices) -> None:
    """Put targets into one group that a cell sees in one; its number is the id of the first."""
    groups: dict[tuple[int, int], int] = {}
    for index in np.flatnonzero(members.group[seen]).tolist():
        name = (int(members.cell[seen[index]]), int(members.group[seen[index]]))
        table.group[row[index]] = groups.setdefault(name, int(table.track_id[row[index]]))
