"""Where two tracks seem one and a new one begins beside them, one of the two has parted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from mctrack_ros.fusion.management.duplicates import Doubt
from mctrack_ros.fusion.table import TrackTable

LATELY_S = 2.0
"""A track that began longer ago than this is nobody's who was there, s."""
SOON_S = 0.6
"""Two who come into doubt later than this after it began were two when it did, s."""
DOUBT = 0.1
"""Of the time after which two are one target so much raises the doubt that they are two."""
KEPT = ('track_id', 'first_ns', 'origin')
"""What stays of a track that goes on as another."""
NAMING = ('group', 'origin', 'beside')
"""Columns that name other tracks."""


def parted(
    table: TrackTable,
    doubts: Mapping[tuple[int, int], Doubt],
    busy: Iterable[int],
    stamp_ns: int,
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
    doubts : mapping of (int, int) to Doubt
        Tracks, by their ids, that have hardly been told apart for a moment at least.
    busy : iterable of int
        Rows that other things happen to.
    stamp_ns : int
        The tick's stamp, ns.

    """
    if not doubts:
        return []
    age_s = (stamp_ns - table.first_ns) / 1e9
    lately = table.confirmed & (table.beside > 0) & (age_s < LATELY_S)
    if not np.count_nonzero(lately):
        return []
    pairs: dict[int, list[tuple[int, int]]] = {name: [] for name in table.beside[lately].tolist()}
    for (one, other), doubt in doubts.items():
        if one in pairs:
            pairs[one].append((other, doubt.began_ns))
        if other in pairs:
            pairs[other].append((one, doubt.began_ns))
    if not any(pairs.values()):
        return []
    sure = table.confirmed.nonzero()[0]
    rows = dict(zip(table.track_id[sure].tolist(), sure.tolist()))
    found: list[tuple[int, int]] = []
    used = set(busy)
    for row in np.flatnonzero(lately).tolist():
        own, latest_ns = int(table.track_id[row]), int(table.first_ns[row]) + round(SOON_S * 1e9)
        name = int(table.beside[row])
        for other, began_ns in pairs[name]:
            if other == own or began_ns > latest_ns or not {name, other} <= rows.keys():
                continue
            concerned = {row, rows[name], rows[other]}
            if not used & concerned:
                used |= concerned
                found.append((rows[name], row))
    return found


def go_on_as(table: TrackTable, kept: int, dropped: int) -> None:
    """Let a track be where another one is, which is his from now on but for the name."""
    stays = [*KEPT]
    if not table.template[dropped].any():
        stays.append('template')
    if np.isnan(table.extent[dropped]).any():
        stays.append('extent')
    own = {name: getattr(table, name)[kept].copy() for name in stays}
    table.records[kept] = table.records[dropped]
    for name, value in own.items():
        getattr(table, name)[kept] = value
    for name in NAMING:
        names = getattr(table, name)
        names[names == table.track_id[dropped]] = table.track_id[kept]
    table.beside[kept], table.previous_id[kept] = 0, table.track_id[dropped]
