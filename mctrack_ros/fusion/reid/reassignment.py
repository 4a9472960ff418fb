"""Reassignment of ids after an encounter: they follow appearance, not the tracks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist
from scipy.special import expit

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.neighbours import NearPairs, is_near
from mctrack_ros.fusion.reid.appearance import AppearanceModel, samples
from mctrack_ros.fusion.reid.id_hypotheses import IdHypotheses
from mctrack_ros.fusion.reid.lost_targets import NEW, LostTargets
from mctrack_ros.fusion.table import TRACKS, TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

IMPOSSIBLE = 1e6

SAMPLE_S, LONGEST_SAMPLE_S = 0.5, 5.0
"""Time alone, of all cameras together, after which a sample is compared; and after which an id is
kept though several fit, s: with the next, chosen on the tuning matches of the pitch."""

OUTLIER_DISTANCE = 4.0
"""How far the colours of two people usually differ, in variances of one person's."""

KEEP = 0.15
"""How much more probable another id must be, log: without it, 17 switches more on PETS, view 1."""

MOST_MEETINGS = 300
"""Most pairs of a lost target and a track near it that are looked at in one tick."""


class Reassignment:
    """
    Corrects ids by appearance.

    After two targets came near each other, either track may be either target. When one was seen
    alone for a while, by all cameras together, its sample is compared with the galleries of all
    targets that it may be, and the ids of all concerned are assigned together. A lost target may
    be any new track near by.

    Parameters
    ----------
    config : JointConfig
        Parameters.

    Attributes
    ----------
    model : AppearanceModel
        How much targets differ from themselves.
    lost : LostTargets
        Who is tracked no more.
    certainty : dict of int to float
        Of the changes of the last step, by old id: how probable each is, against the next best.

    """

    def __init__(self, config: JointConfig) -> None:
        self._config = config.reid
        self.model = AppearanceModel()
        self._hypotheses = IdHypotheses()
        self.lost = LostTargets(config, self.model)
        self.certainty: dict[int, float] = {}

    def note_lost(self, removed: TrackTable, table: TrackTable, stamp_ns: int) -> None:
        """Remember confirmed tracks that end; whoever is where they may have gone may be them."""
        removed = removed.select(removed.confirmed)
        names, reach = removed.track_id.tolist(), self.lost.reach(stamp_ns - removed.seen_ns)
        apart = cdist(removed.mean[:, :2], table.mean[:, :2])
        near = table.confirmed & (apart < reach[:, None])
        for row, column in np.argwhere(near)[:MOST_MEETINGS].tolist():
            self._hypotheses.meet(int(table.track_id[column]), names[row])
        self._lose(removed, stamp_ns)

    def forget(self, name: int) -> None:
        """Forget one who turned out to be another."""
        self._hypotheses.erase([name])

    def differences(self, table: TrackTable, row: int, old_id: int) -> tuple[float, float]:
        """Return by how much a track's sample differs from its target and from the former one."""
        both = table.extended(self.lost.tracks)
        sample, former = samples(table, np.array([row])), both.track_id == old_id
        own = self.model.distances(sample, table.gallery[[row]])
        other = self.model.distances(sample, both.gallery[former & (both.gallery_s > 0.0)])
        return float(own[0, 0]), float(other.min(initial=NEW)) if other.size else NEW

    def step(
        self, table: TrackTable, near: NearPairs, stamp_ns: int, confirmed: Mask
    ) -> dict[int, int]:
        """
        Learn the galleries of those who are alone, and return which ids change.

        Parameters
        ----------
        table : TrackTable
            Its galleries are changed, its ids are not.
        near : pair of (k,) int arrays
            Rows of those who are near each other, by `contact_distance` at least.
        stamp_ns : int
            The tick's stamp, ns.
        confirmed : (n,) bool array
            The newly confirmed.

        Returns
        -------
        dict of int to int
            Old ids to new ones, all to be changed at once.

        """
        self.certainty.clear()
        for name in self.lost.expire(stamp_ns):
            self.forget(name)
        fresh = confirmed.nonzero()[0].tolist()
        batch = samples(table, np.array(fresh, np.intp))  # before contacts begin them anew
        due = self._note_contacts(table, near, stamp_ns)
        changes = self._found_again(table, fresh, batch, stamp_ns)
        if changes or not len(due):
            return changes
        table.judge_s[due] *= 2.0
        return self._judged(table, due, stamp_ns)

    def _note_contacts(self, table: TrackTable, near: NearPairs, stamp_ns: int) -> Indices:
        """Note who is in contact; return the rows (k,) of those who were alone for long enough."""
        touch, due = _contacts(table.fixed, *near, self._config.contact_distance)
        one, other = (table.track_id[rows[touch]].tolist() for rows in near)
        for pair in zip(one, other):
            self._hypotheses.meet(*pair)
        table.contact_ns[table.in_contact] = stamp_ns
        table.contact_place[table.in_contact] = table.mean[table.in_contact, :2]
        return due

    def _found_again(
        self, table: TrackTable, fresh: list[int], batch: Floats, stamp_ns: int
    ) -> dict[int, int]:
        """Note which lost targets new tracks may be; return which they surely are."""
        found: dict[int, int] = {}
        self.lost.found.clear()
        for row, sample in zip(fresh, batch):
            name = int(table.track_id[row])
            may_be = self._hypotheses.of(name).union(self.lost.near(table.mean[row, :2], stamp_ns))
            self._hypotheses.settle(name, may_be)
            best = self.lost.find(table, row, sample, stamp_ns)
            if best:
                found[name] = best
                self.lost.give_gallery(best, table, row)
                self.certainty[name] = float(expit(-0.5 * self.lost.found[best]))
                self._replace({name: best})
                self._hypotheses.become(name, best)
        return found

    def _judged(self, table: TrackTable, due: Indices, stamp_ns: int) -> dict[int, int]:
        """Learn the galleries of those due who are surely themselves, and judge the others."""
        row_of = dict(zip(table.track_id.tolist(), range(len(table))))
        present = table.track_id[table.confirmed].tolist()
        changes: dict[int, int] = {}
        judged: set[int] = set()
        for name in table.track_id[due].tolist():
            if len(self._hypotheses.of(name)) == 1:
                self.model.learn(table, row_of[name])
            elif name not in judged:
                connected = self._hypotheses.connected(name, present)
                judged.update(connected)
                rows = np.array([row_of[one] for one in connected], np.intp)
                changes |= self._assigned(table, rows, stamp_ns)
        return changes

    def _assigned(self, table: TrackTable, rows: Indices, stamp_ns: int) -> dict[int, int]:
        """Assign the ids of those who may be one another; return those that change."""
        connected, sample_s = table.track_id[rows].tolist(), table.sample_s[rows]
        may_be = [self._hypotheses.of(one) for one in connected]
        targets = self._targets(table, sorted(frozenset().union(*may_be)))
        cost, is_outlier = self._costs(table, rows, targets, may_be)
        taken, margin = assigned(cost)
        margin[is_outlier] = 0.0
        self.certainty |= dict(zip(connected, expit(margin).tolist()))
        is_sure = (margin > 0.0) | (sample_s >= LONGEST_SAMPLE_S)
        changes = dict(zip(connected, targets.track_id[taken].tolist()))
        self._settle(changes, may_be, is_sure & (sample_s >= SAMPLE_S))
        self._exchange(table, rows, targets.select(taken), stamp_ns)
        return {old: new for old, new in changes.items() if old != new}

    def _settle(self, changes: dict[int, int], may_be: list[frozenset[int]], sure: Mask) -> None:
        """Note who tracks (k,) may be after these changes, old id to new: some are sure."""
        self._replace(changes)
        settled = {new for new, is_sure in zip(changes.values(), sure.tolist()) if is_sure}
        for new, may in zip(changes.values(), may_be):
            self._hypotheses.settle(new, () if new in settled else may - settled)

    def _exchange(
        self, table: TrackTable, rows: Indices, targets: TrackTable, stamp_ns: int
    ) -> None:
        """Give tracks (k,) the galleries of their targets (k,); lose whom none is any more."""
        gone = table.select(rows[~np.isin(table.track_id[rows], targets.track_id)])
        met = gone.contact_ns > 0
        gone.mean[met, :2], gone.seen_ns[met] = gone.contact_place[met], gone.contact_ns[met]
        table.gallery[rows], table.gallery_s[rows] = targets.gallery, targets.gallery_s
        self._hypotheses.erase(gone.track_id[gone.gallery_s == 0.0].tolist())
        self._lose(gone.select(gone.gallery_s > 0.0), stamp_ns)

    def _targets(self, table: TrackTable, names: list[int]) -> TrackTable:
        """Return the records of targets (k,), tracked or lost."""
        both = table.extended(self.lost.tracks)
        row_of = dict(zip(both.track_id.tolist(), range(len(both))))
        return both.select(np.array([row_of[name] for name in names], np.intp))

    def _costs(
        self, table: TrackTable, rows: Indices, targets: TrackTable, may_be: list[frozenset[int]]
    ) -> tuple[Floats, Mask]:
        """
        Return what it costs that tracks (k,) are targets (m,), and whose sample is strange (k,).

        That is the negative logarithm of a Cauchy-like density of the colours' difference: light
        and other people's pixels are outliers, so what differs much tells little more. A sample
        like nobody's decides nothing.
        """
        names, unknown = targets.track_id, targets.gallery_s == 0.0
        allowed = np.array([np.isin(names, list(may)) for may in may_be])
        is_own = table.track_id[rows, None] == names
        apart = self.model.distances(samples(table, rows), targets.gallery)
        apart[:, unknown] = OUTLIER_DISTANCE
        is_outlier = np.where(allowed, apart, np.inf).min(axis=1) >= OUTLIER_DISTANCE
        apart[is_own & unknown] = NEW
        is_informative = ~is_outlier & (table.sample_s[rows] >= SAMPLE_S) & self.model.is_trained
        cost = is_informative[:, None] * np.log1p(apart) - KEEP * is_own
        return np.where(allowed, cost, IMPOSSIBLE), is_outlier

    def _replace(self, names: dict[int, int]) -> None:
        """Let those who were called one thing be called another, all at once."""
        may_be = [self._hypotheses.of(old) for old in names]
        for old in names.keys() - names.values():
            self._hypotheses.end(old)
        for new, may in zip(names.values(), may_be):
            self.lost.remove(new)
            self._hypotheses.settle(new, may)

    def _lose(self, tracks: TrackTable, stamp_ns: int) -> None:
        """Remember tracks that end; who was never seen alone is nobody's other self."""
        for name in tracks.track_id.tolist():
            self._hypotheses.end(name)
        self._hypotheses.erase(tracks.track_id[tracks.gallery_s == 0.0].tolist())
        for name in self.lost.add(tracks, stamp_ns):
            self.forget(name)


def assigned(cost: Floats) -> tuple[Indices, Floats]:
    """Return the column of each row (k,) of least total cost, and the next best's lead (k,)."""
    rows, taken = linear_sum_assignment(cost)
    rest = cost.copy()
    rest[rows, taken] = IMPOSSIBLE
    return taken, rest.min(axis=1) - cost[rows, taken]


@compiled(types.Tuple([types.i8[::1], types.i8[::1]])(TRACKS, INTS_1D, INTS_1D, types.f8))
def _contacts(
    tracks: Any, one: Indices, other: Indices, distance: float
) -> tuple[Indices, Indices]:
    """
    Note who is in contact: the confirmed who are so near. Their samples begin anew.

    Returns
    -------
    touch : (k,) int64 array
        Which pairs of rows are.
    due : (m,) int64 array
        Whose samples are long enough.

    """
    mean, confirmed, sample = tracks['mean'], tracks['confirmed'], tracks['sample']
    tracks['in_contact'][:] = False
    touch, due = np.empty(len(one), np.bool_), np.empty(len(tracks), np.bool_)
    for pair in range(len(one)):
        touch[pair] = confirmed[one[pair]] and confirmed[other[pair]]
        touch[pair] &= is_near(mean, one[pair], other[pair], distance)
        if touch[pair]:
            for row in (one[pair], other[pair]):
                tracks[row]['in_contact'], sample[row], tracks[row]['sample_s'] = True, 0.0, 0.0
    for row in range(len(tracks)):
        own = tracks[row]
        if own['sample_s'] == 0.0:
            own['judge_s'] = SAMPLE_S
        due[row] = own['confirmed'] and own['sample_s'] >= own['judge_s']
    return np.flatnonzero(touch), np.flatnonzero(due)
