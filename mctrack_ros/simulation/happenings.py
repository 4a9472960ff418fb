"""True tracking events of a camera: new, enter, exit, merge, split (event-tracking, Table 1)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mctrack_ros.interfaces import MEMBERS, EventCode, Events
from mctrack_ros.simulation.rendering.sight import View
from mctrack_ros.simulation.world import World

HOLD_S = 0.4
"""A split and an exit count once they have lasted this long, s; a merge and an entry at once."""

Booleans = NDArray[np.bool_]
Indices = NDArray[np.int64]
_Happening = tuple[EventCode, int, Indices]


class EventWatcher:
    """
    Watch one camera's views in order and report what happened.

    A person is in view while the foot point is in the image. People whose silhouettes overlap
    or touch form one blob; a blob that joins others is a merge, one that falls apart a split.
    Somebody whom no camera has seen before is new, otherwise enters.

    Parameters
    ----------
    world : World
        The match.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: World, camera_index: int) -> None:
        self._world, self._index = world, camera_index
        self._hold = max(math.ceil(HOLD_S * world.scenario.rate_hz - 1e-9), 1)
        count = len(world.ids)
        self._inside = np.zeros(count, np.bool_)
        self._out_for = np.zeros(count, np.int64)
        self._joined = np.zeros((count, count), np.bool_)
        self._apart_for = np.zeros((count, count), np.int64)
        self._blob = np.arange(count)

    def step(self, step: int, view: View) -> Events:
        """Return what happened between the previous step and this one."""
        seen = np.zeros_like(self._inside)
        seen[view.person] = self._world.feet_in_view[step, self._index, view.person]
        was_inside, was_blob = self._inside, self._blob
        self._out_for = np.where(seen, 0, self._out_for + 1)
        self._inside = seen | (was_inside & (self._out_for < self._hold))
        self._blob = self._blobs(view)
        rows = [*self._passages(step, was_inside)]
        rows += _parted(EventCode.MERGE, self._blob, was_blob, self._inside)
        rows += _parted(EventCode.SPLIT, was_blob, self._blob, was_inside & self._inside)
        rows.sort(key=lambda row: row[:2])
        return self._events(step, rows)

    def _passages(self, step: int, was_inside: Booleans) -> Iterator[_Happening]:
        """Yield who comes into view and who leaves it."""
        for person in np.flatnonzero(self._inside & ~was_inside).tolist():
            known = self._world.feet_in_view[:step, :, person].any()
            yield EventCode.ENTER if known else EventCode.NEW, person, np.array([person])
        for person in np.flatnonzero(was_inside & ~self._inside).tolist():
            yield EventCode.EXIT, person, np.array([person])

    def _blobs(self, view: View) -> Indices:
        """Return for each person the first person of the blob, after the hold time."""
        touching = np.zeros_like(self._joined)
        one, other = view.person[view.touching.T]
        touching[one, other] = touching[other, one] = True
        self._apart_for = np.where(touching, 0, self._apart_for + 1)
        self._joined = touching | (self._joined & (self._apart_for < self._hold))
        self._joined &= self._inside[:, None] & self._inside[None]
        _, blob = connected_components(csr_array(self._joined), directed=False)
        _, first = np.unique(blob, return_index=True)
        return np.asarray(first[blob], np.int64)

    def _events(self, step: int, rows: list[_Happening]) -> Events:
        place = self._world.motion.position[step]
        position = np.zeros((len(rows), 3))
        others = np.zeros((len(rows), MEMBERS), np.uint32)
        for row, (_, person, members) in enumerate(rows):
            position[row, :2] = place[members].mean(axis=0)
            rest = self._world.ids[members[members != person]][:MEMBERS]
            others[row, : len(rest)] = rest
        people = np.array([person for _, person, _ in rows], np.int64)
        return Events.build(
            self._world.scenario.stamp_ns(step),
            position=position,
            track_id=self._world.ids[people],
            others=others,
            event=np.array([code for code, *_ in rows], np.uint16),
            camera=np.full(len(rows), self._index, np.uint16),
        )


def _parted(
    code: EventCode, whole: Indices, parts: Indices, counted: Booleans
) -> list[_Happening]:
    """Return an event for every part of a blob but the largest: what joins it or leaves it."""
    rows = []
    for blob in np.unique(whole[counted]).tolist():
        members = np.flatnonzero(counted & (whole == blob))
        labels, sizes = np.unique(parts[members], return_counts=True)
        for label in labels[np.argsort(-sizes, kind='stable')][1:].tolist():
            rows.append((code, int(members[parts[members] == label][0]), members))
    return rows
