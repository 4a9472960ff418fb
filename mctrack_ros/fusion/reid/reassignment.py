"""Who is who after an encounter: ids follow what people look like, not who came out where."""

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
from mctrack_ros.fusion.reid.gallery import STRANGE, AppearanceSample, Gallery
from mctrack_ros.fusion.reid.id_hypotheses import IdHypotheses
from mctrack_ros.fusion.reid.lost_targets import NEW, LostTargets
from mctrack_ros.fusion.reid.samples import first_sample, sample_of
from mctrack_ros.fusion.table import TRACKS, TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

IMPOSSIBLE = 1e6

SAMPLE_S, LONGEST_SAMPLE_S = 0.5, 5.0
"""For so long one must be seen alone, by all cameras together, to be recognised; and after so long
one who looks like several keeps his id, s. These and the next two were chosen on the tuning
matches of the pitch."""

KEEP = 0.15
"""How much more probable it must be before an id changes, log."""

MARGIN = 0.1
"""How much less probable all others must be before it is settled, log."""

MOST_MEETINGS = 300
"""So many pairs of who was lost and who was near him met in one tick at most: more is a flood."""

PAST_S = 2.7
"""Who was tracked for a second longer than it takes to join two was somebody of his own, s."""


class Reassignment:
    """
    Gives ids to those who look like those who had them.

    Whoever comes near another may leave with the other's track: from then on either may be
    either. Once somebody has been seen alone for a while, by all cameras together, the mean of
    his colours is held against those of all whom he may be, and the ids of all concerned are
    assigned together. One who was lost is among those that whoever turns up near by may be.

    Parameters
    ----------
    config : JointConfig
        Parameters.

    Attributes
    ----------
    gallery : Gallery
        Portraits of targets, tracked or lost.
    lost : LostTargets
        Who is tracked no more.
    certainty : dict of int to float
        Of the changes of the last step, by old id: how probable each is, against the next best.

    """

    def __init__(self, config: JointConfig) -> None:
        self._config = config.recognition
        self.gallery = Gallery()
        self._hypotheses = IdHypotheses()
        self.lost = LostTargets(config, self.gallery)
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

    def note_joined(self, removed: TrackTable, stamp_ns: int) -> None:
        """
        Remember tracks that were taken for duplicates though they had a past of their own.

        Two who walk as one are one track to all cameras; when they part, the new track is the
        other one again.
        """
        age_s = (stamp_ns - removed.first_ns) / 1e9
        own = removed.confirmed & (age_s > PAST_S)
        if own.any():
            self._remember(removed.select(own), stamp_ns)

    def forget(self, name: int) -> None:
        """Forget one who turned out to be another."""
        self.gallery.forget(name)
        self._hypotheses.erase([name])

    def knows(self, one: NDArray[np.uint32], other: NDArray[np.uint32]) -> Mask:
        """Tell which pairs, (k,), have each been seen alone: hardly one and the same."""
        known, pairs = self.gallery, zip(one.tolist(), other.tolist())
        return np.array([first in known and second in known for first, second in pairs], np.bool_)

    def step(
        self, table: TrackTable, near: NearPairs, stamp_ns: int, confirmed: Mask
    ) -> dict[int, int]:
        """
        Learn what those who are alone look like, and tell which ids change.

        Parameters
        ----------
        table : TrackTable
            Its looks are changed, its ids are not.
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
        batch = [first_sample(table, row) for row in fresh]  # before contacts let them begin anew
        touch, due = _contacts(table.fixed, *near, self._config.contact_distance)
        one, other = (table.track_id[rows[touch]].tolist() for rows in near)
        for pair in zip(one, other):
            self._hypotheses.meet(*pair)
        changes = self._found_again(table, fresh, batch, stamp_ns)
        if changes or not len(due):
            return changes
        table.judge_s[due] *= 2.0
        return self._judged(table, due, stamp_ns)

    def _found_again(
        self, table: TrackTable, fresh: list[int], batch: list[Floats], stamp_ns: int
    ) -> dict[int, int]:
        """Note who of the lost new tracks that look so may be; return who they surely are."""
        found: dict[int, int] = {}
        self.lost.found.clear()
        for row, look in zip(fresh, batch):
            name = int(table.track_id[row])
            may_be = self._hypotheses.of(name).union(self.lost.near(table.mean[row, :2], stamp_ns))
            self._hypotheses.settle(name, may_be)
            best = self.lost.find(table, row, look, stamp_ns)
            if best:
                found[name] = best
                self.certainty[name] = float(expit(-0.5 * self.lost.found[best]))
                self._replace({name: best})
                self._hypotheses.become(name, best)
        return found

    def _judged(self, table: TrackTable, due: Indices, stamp_ns: int) -> dict[int, int]:
        """Learn what those due look like who are surely themselves, and judge the others."""
        row_of = dict(zip(table.track_id.tolist(), range(len(table))))
        present = table.track_id[table.confirmed].tolist()
        changes: dict[int, int] = {}
        judged: set[int] = set()
        for name in table.track_id[due].tolist():
            row = row_of[name]
            if len(self._hypotheses.of(name)) == 1:
                self.gallery.learn(name, sample_of(table, row))
                table.look[row], table.look_s[row] = 0.0, 0.0
            elif name not in judged:
                circle = self._hypotheses.circle(name, present)
                judged.update(circle)
                batch = [sample_of(table, row_of[one]) for one in circle]
                changes |= self._assigned(circle, batch)
        gone = changes.keys() - changes.values()
        rows = [row for name, row in row_of.items() if name in gone and name in self.gallery]
        self._hypotheses.erase(gone - self.gallery.names())
        self._lose(table.select(np.array(rows, np.intp)), stamp_ns)
        return changes

    def _assigned(self, circle: list[int], batch: list[AppearanceSample]) -> dict[int, int]:
        """
        Assign the ids of those who may be one another; return those that change.

        An id costs the negative logarithm of a Cauchy-like density of the colours' difference:
        light and other people's pixels are outliers, so what differs much tells little more.
        Who looks like nobody known decides nothing by his looks, and is not settled by them.
        """
        gallery = self.gallery
        may_be = [self._hypotheses.of(one) for one in circle]
        names = sorted(frozenset().union(*may_be))
        cost = np.full((len(circle), len(names)), IMPOSSIBLE)
        is_strange = np.zeros(len(circle), np.bool_)
        for row, (own, look) in enumerate(zip(circle, batch)):
            weight = gallery.weight(look) if look.seconds >= SAMPLE_S else 0.0
            differences = {name: gallery.difference(look, name) for name in may_be[row]}
            if min(differences.values()) >= STRANGE:  # so strange is who is not known
                is_strange[row], weight = True, 0.0  # others' pixels are among his
            if own not in gallery:
                differences[own] = NEW
            for name, difference in differences.items():
                cost[row, names.index(name)] = weight * np.log1p(difference)
            cost[row, names.index(own)] -= KEEP
        taken = linear_sum_assignment(cost)[1]
        chosen = [names[column] for column in taken.tolist()]
        best = cost[np.arange(len(circle)), taken]
        cost[np.arange(len(circle)), taken] = IMPOSSIBLE
        margin = np.where(is_strange, 0.0, cost.min(axis=1) - best)
        settled = {
            name
            for name, look, lead in zip(chosen, batch, margin.tolist())
            if look.seconds >= SAMPLE_S and (lead > MARGIN or look.seconds >= LONGEST_SAMPLE_S)
        }
        self._replace(dict(zip(circle, chosen)))
        for name, may in zip(chosen, may_be):
            self._hypotheses.settle(name, () if name in settled else may - settled)
        changed = [index for index, old in enumerate(circle) if old != chosen[index]]
        self.certainty |= {circle[index]: float(expit(margin[index])) for index in changed}
        return {circle[index]: chosen[index] for index in changed}

    def _replace(self, names: dict[int, int]) -> None:
        """Let those who were called one thing be called another, all at once."""
        may_be = [self._hypotheses.of(old) for old in names]
        for old in names.keys() - names.values():
            self._hypotheses.end(old)
        for new, may in zip(names.values(), may_be):
            self.lost.remove(new)
            self._hypotheses.settle(new, may)

    def _lose(self, tracks: TrackTable, stamp_ns: int) -> None:
        """Remember tracks that end; nobody may be one of them without a portrait."""
        names = set(tracks.track_id.tolist())
        for name in names:
            self._hypotheses.end(name)
        self._hypotheses.erase(names - self.gallery.names())
        self._remember(tracks, stamp_ns)

    def _remember(self, tracks: TrackTable, stamp_ns: int) -> None:
        for name in self.lost.add(tracks, stamp_ns):
            self.forget(name)


@compiled(types.Tuple([types.i8[::1], types.i8[::1]])(TRACKS, INTS_1D, INTS_1D, types.f8))
def _contacts(
    tracks: Any, one: Indices, other: Indices, distance: float
) -> tuple[Indices, Indices]:
    """
    Note who is in contact: the confirmed who are so near. Their looks begin anew.

    Returns
    -------
    touch : (k,) int64 array
        Which pairs of rows are.
    due : (m,) int64 array
        Who has been looked at for long enough; who is not yet begins anew.

    """
    mean, confirmed, look = tracks['mean'], tracks['confirmed'], tracks['look']
    tracks['in_contact'][:] = False
    touch, due = np.empty(len(one), np.bool_), np.empty(len(tracks), np.bool_)
    for pair in range(len(one)):
        touch[pair] = confirmed[one[pair]] and confirmed[other[pair]]
        touch[pair] &= is_near(mean, one[pair], other[pair], distance)
        if touch[pair]:
            for row in (one[pair], other[pair]):
                tracks[row]['in_contact'], look[row], tracks[row]['look_s'] = True, 0.0, 0.0
    for row in range(len(tracks)):
        own = tracks[row]
        if own['look_s'] == 0.0:
            own['judge_s'] = SAMPLE_S
        due[row] = own['confirmed'] and own['look_s'] >= own['judge_s']
    return np.flatnonzero(touch), np.flatnonzero(due)
