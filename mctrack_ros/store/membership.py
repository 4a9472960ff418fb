"""Membership of groups, from when to when."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, select

from mctrack_ros.interfaces import PAUSE_NS
from mctrack_ros.store.schema import GROUPS, MEMBERS, upsert


@dataclass(slots=True)
class _Member:
    """A membership as far as it is known."""

    group: int
    began_ns: int
    ended_ns: int
    is_new: bool = True


@dataclass(slots=True)
class Memberships:
    """The memberships of a run, put together from chunks in the order of time."""

    _open: dict[int, _Member] = field(default_factory=dict)
    _over: list[tuple[int, _Member]] = field(default_factory=list)

    def copy(self) -> Self:
        """Return a copy that changes alone."""
        return deepcopy(self)

    def take_up(self, connection: Connection, run: int, last_ns: int) -> None:
        """Go on with the memberships of a run that last until a stamp, ns."""
        asked = select(MEMBERS).where(
            MEMBERS.c.run_id == run, MEMBERS.c.ended_ns >= last_ns - PAUSE_NS
        )
        for row in connection.execute(asked.order_by(MEMBERS.c.ended_ns)):
            member = _Member(row.group_id, row.began_ns, row.ended_ns, is_new=False)
            self._open[row.track_id] = member

    def add(self, track: int, stamp_ns: NDArray[np.int64], group: NDArray[np.uint32]) -> None:
        """Append the groups of a track, 0: none, at ascending stamps, ns."""
        if not group.any():
            return
        edges = np.flatnonzero(np.diff(group)) + 1
        for part in np.split(np.arange(len(group)), edges):
            number = int(group[part[0]])
            began_ns, ended_ns = int(stamp_ns[part[0]]), int(stamp_ns[part[-1]])
            member = self._open.get(track)
            if number == 0:
                continue
            if member and member.group == number and began_ns - member.ended_ns <= PAUSE_NS:
                member.ended_ns, member.is_new = ended_ns, True
                continue
            if member and member.is_new:
                self._over.append((track, member))
            self._open[track] = _Member(number, began_ns, ended_ns)

    def changed(self, run: int) -> list[dict[str, Any]]:
        """Return the memberships that changed since the last time, as rows of the table."""
        new = self._over + [(track, each) for track, each in self._open.items() if each.is_new]
        for _, member in new:
            member.is_new = False
        self._over = []
        return [
            {
                'run_id': run,
                'group_id': member.group,
                'track_id': track,
                'began_ns': member.began_ns,
                'ended_ns': member.ended_ns,
            }
            for track, member in new
        ]


def write_memberships(connection: Connection, members: Sequence[dict[str, Any]]) -> None:
    """Write memberships, new or longer than before, and from when to when their groups are."""
    if not members:
        return
    statement = upsert(connection, MEMBERS)
    keys = ['run_id', 'group_id', 'track_id', 'began_ns']
    kept = {'ended_ns': statement.excluded.ended_ns}
    connection.execute(statement.on_conflict_do_update(index_elements=keys, set_=kept), members)
    groups: dict[int, tuple[int, int]] = {}
    for row in members:
        began_ns, ended_ns = groups.get(row['group_id'], (row['began_ns'], row['ended_ns']))
        span = min(began_ns, row['began_ns']), max(ended_ns, row['ended_ns'])
        groups[row['group_id']] = span
    statement = upsert(connection, GROUPS)
    later = GROUPS.c.ended_ns < statement.excluded.ended_ns
    connection.execute(
        statement.on_conflict_do_update(
            index_elements=['run_id', 'group_id'],
            set_={'ended_ns': statement.excluded.ended_ns},
            where=later,
        ),
        [
            {'run_id': members[0]['run_id'], 'group_id': group, 'began_ns': began, 'ended_ns': end}
            for group, (began, end) in groups.items()
        ],
    )
