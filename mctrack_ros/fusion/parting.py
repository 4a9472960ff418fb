"""Where two tracks seem one and a new one begins beside them, one of the two has parted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mctrack_ros.fusion.table import TrackTable

LATELY_S = 2.0
"""A track that began longer ago than this is nobody's who was there, s."""
DOUBT = 0.1
"""Of the time after which two are one target so much raises the doubt that they are two."""
KEPT = ('track_id', 'first_ns', 'origin')
"""What stays of a track that goes on as another."""


def parted(
    table: TrackTable, doubtful: Sequence[tuple[int, int]], stamp_ns: int
) -> list[tuple[int, int]]:
    """
    Return rows of tracks, and of the new ones whose targets they are: (kept, dropped).

    Where a new track is confirmed that began beside one of two that cameras hardly tell apart,
    it is likelier that this one's target has parted from the other's than that somebody came out
    of nothing and the two still stand in one place.

    Parameters
    ----------
    table : TrackTable
        All tracks.
    doubtful : sequence of (int, int)
        Ids of tracks, two and two, that have hardly been told apart for a moment at least.
    stamp_ns : int
        The tick's stamp, ns.

    """
    if not doubtful:
        return []
    lately = table.confirmed & (table.beside > 0) & (stamp_ns - table.first_ns < LATELY_S * 1e9)
    if not np.count_nonzero(lately):
        return []
    rows = dict(zip(table.track_id.tolist(), range(len(table))))
    found: list[tuple[int, int]] = []
    used: set[int] = set()
    for row in np.flatnonzero(lately).tolist():
        name, own = int(table.beside[row]), int(table.track_id[row])
        for pair in doubtful:
            if name not in pair or own in pair or not rows.keys() >= set(pair):
                continue
            known = {rows[pair[0]], rows[pair[1]]}
            if table.confirmed[list(known)].all() and not used & {row, *known}:
                used |= {row, *known}
                found.append((rows[name], row))
    return found


def go_on_as(table: TrackTable, kept: int, dropped: int) -> None:
    """Let a track be where another one is, which is his from now on but for the name."""
    own = {name: getattr(table, name)[kept] for name in KEPT}
    table.records[kept] = table.records[dropped]
    for name, value in own.items():
        getattr(table, name)[kept] = value
    table.beside[kept], table.previous_id[kept] = 0, table.track_id[dropped]
