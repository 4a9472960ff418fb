"""Identities, by the corrections that fusion published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, bindparam, select

from mctrack_ros.store.rows import Stored, load_rows
from mctrack_ros.store.schema import CORRECTIONS

NEAR_M = 1.5
"""From here on fusion takes two people for exchangeable, and tracks for those of one person."""
_LOOK_BACK_NS = 120_000_000_000
"""How long before a correction the encounter is looked for."""
_LATEST_NS = 2**63 - 1  # what a column of 64 bits holds
_KNOWN = (
    select(CORRECTIONS)
    .where(CORRECTIONS.c.run_id == bindparam('run'))
    .where(CORRECTIONS.c.stamp_ns <= bindparam('known_ns'))
    .order_by(CORRECTIONS.c.stamp_ns, CORRECTIONS.c.number, CORRECTIONS.c.line)
)


@dataclass(frozen=True, slots=True)
class Correction:
    """
    A correction of an identity.

    Attributes
    ----------
    stamp_ns : int
        From then on it is called by its new id, ns.
    since_ns : int
        From then on it was that already, ns.
    old_id, new_id : int
        What it was called, and is called now.

    """

    stamp_ns: int
    since_ns: int
    old_id: int
    new_id: int


class Identities:
    """
    Whom rows of tracks are taken for.

    Parameters
    ----------
    corrections : sequence of Correction
        In the order of their stamps.

    """

    def __init__(self, corrections: Sequence[Correction]) -> None:
        self._corrections = corrections

    def lives(self, track_id: NDArray[np.int64], stamp_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return whom rows are taken for, by their ids and stamps, (n,)."""
        lives = track_id.copy()
        known = set(np.unique(lives).tolist())
        for _, tick in groupby(self._corrections, key=lambda each: each.stamp_ns):
            before = lives.copy() if known else lives
            for each in tick:
                if each.old_id not in known:
                    continue
                concerned = (stamp_ns < each.stamp_ns) & (stamp_ns >= each.since_ns)
                lives[concerned & (before == each.old_id)] = each.new_id
                known.add(each.new_id)
        return lives

    def names(self, life: int) -> set[int]:
        """Return all ids that one may have been called by."""
        names = {life}
        for each in reversed(self._corrections):
            if each.new_id in names:
                names.add(each.old_id)
        return names


def load_identities(
    connection: Connection, stored: Stored, as_of_ns: int | None = None
) -> Identities:
    """Return the identities of a run, as known now, or at a time, ns."""
    known_ns = _LATEST_NS if as_of_ns is None else as_of_ns
    return Identities(
        [
            Correction(row.stamp_ns, row.since_ns, row.old_id, row.new_id)
            for row in connection.execute(_KNOWN, {'run': stored.run, 'known_ns': known_ns})
        ]
    )


def since_when(
    connection: Connection, stored: Stored, stamp_ns: int, old_id: int, new_id: int
) -> int:
    """
    Return from when on one who is corrected was the other already, ns.

    If both were tracked, apart from each other, it is since they last met: within `NEAR_M`, the
    closest instant. Otherwise from the beginning: the other was lost by then, or both tracks were
    of one person.
    """
    between = (stamp_ns - _LOOK_BACK_NS, stamp_ns)
    rows = load_rows(connection, stored, between, tracks=(old_id, new_id)).reported()
    old, new = (rows.select(rows.track_id == each) for each in (old_id, new_id))
    stamps, at_old, at_new = np.intersect1d(old.stamp_ns, new.stamp_ns, return_indices=True)
    distance = np.hypot(*(old.position()[at_old] - new.position()[at_new]).T)
    near = distance <= NEAR_M
    if near.all():
        return stored.began_ns
    if not near.any():
        return int(stamps[np.argmin(distance)])
    last = int(np.flatnonzero(near)[-1])
    apart = np.flatnonzero(~near[:last])
    first = int(apart[-1]) + 1 if len(apart) else 0
    return int(stamps[first + np.argmin(distance[first : last + 1])])
