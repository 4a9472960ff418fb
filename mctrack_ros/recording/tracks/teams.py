"""Teams and the ball among tracks, for sports formats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.recording.tracks.collected import Collected, Layout


@dataclass(frozen=True, slots=True)
class Teams:
    """
    Ids of both teams' tracks, ascending, and of the ball's.

    Whoever is in no team by the layout is at home: readers leave out people without one.
    """

    home: tuple[int, ...]
    away: tuple[int, ...]
    ball: tuple[int, ...]

    @property
    def players(self) -> tuple[int, ...]:
        """Ids of both teams, ascending."""
        return tuple(sorted((*self.home, *self.away)))


def teams_of(rows: Collected, layout: Layout) -> Teams:
    """Return the teams: as the layout says, or by clothing (see `Layout.away`)."""
    tracks = rows.by_track()
    ball = {who for who, part in tracks.items() if rows.class_of(part) == ClassCode.BALL}
    away = layout.away
    if away is None:
        worn = {who: _usual(rows.kit[part]) for who, part in tracks.items() if who not in ball}
        kits = [kit for kit in worn.values() if kit]
        ranked = sorted(set(kits), key=lambda kit: (-kits.count(kit), kit))
        away = frozenset(who for who, kit in worn.items() if kit in ranked[1:2])
    players = tracks.keys() - ball
    return Teams(tuple(sorted(players - away)), tuple(sorted(players & away)), tuple(sorted(ball)))


def _usual(kits: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> int:
    """Return the most frequent cluster that is known; 0: none is."""
    known = kits[kits > 0]
    return int(np.bincount(known).argmax()) if len(known) else 0
