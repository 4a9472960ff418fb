"""What an operator perceives in the car park: who is in an event, where, and who touches whom."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.silhouettes.perceived import Sightings
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation import CarParkWorld, View

PERCEIVED_SHARE, PERCEIVED_PX = 0.4, 60
"""Somebody is perceived in an image with so much visible: share, and pixels."""

PERCEIVED_S = 3.0
"""What is perceived for less than this, s, is no event."""


_Row = tuple[int, int, NDArray[np.float64], bool]


class Operator:
    """
    Watches views in order.

    People who came together are one subject (assumption 3 of section 3); of a car, each time it
    comes or leaves is one, until it is parked or gone.

    Parameters
    ----------
    world : CarParkWorld
        Who is who.

    """

    def __init__(self, world: CarParkWorld) -> None:
        self._world = world
        begins = np.diff(world.active.astype(np.int8), axis=0, prepend=0) > 0
        self._move = np.cumsum(begins, axis=0)
        self._rows: dict[ClassCode, list[_Row]] = {kind: [] for kind in ClassCode}
        self._together: set[tuple[int, int]] = set()

    def watch(self, step: int, view: View) -> None:
        """Note who is seen in an image."""
        active = self._world.active[step]
        clear = (view.visible >= PERCEIVED_SHARE) & (view.visible * view.pixels >= PERCEIVED_PX)
        boxes: dict[tuple[ClassCode, int], list[int]] = {}
        for row, index in enumerate(view.person.tolist()):
            if active[index] and view.visible[row] > 0:
                boxes.setdefault(self._subject(step, index), []).append(row)
        for (kind, key), rows in boxes.items():
            shown = [row for row in rows if clear[row]] or rows
            box = _around(view.box[shown])
            self._rows[kind].append((step, key, box, bool(clear[rows].any())))
        for one, other in view.person[view.touching].tolist():
            subjects = self._subject(step, one), self._subject(step, other)
            if {kind for kind, _ in subjects} == {ClassCode.PERSON}:
                self._together.add((subjects[0][1], subjects[1][1]))

    def perceived(self, kind: ClassCode) -> tuple[Sightings, Sightings]:
        """Return what makes up events of a class, and what is too short or hidden to."""
        rows = self._rows[kind]
        all_of = Sightings(
            np.array([row[0] for row in rows], np.int64),
            np.array([row[1] for row in rows], np.int64),
            np.array([row[2] for row in rows], np.float64).reshape(-1, 4),
        )
        clear = np.array([row[3] for row in rows], np.bool_)
        keys, count = np.unique(all_of.key[clear], return_counts=True)
        lasting = keys[count >= PERCEIVED_S * self._world.scenario.rate_hz]
        seen = np.isin(all_of.key, lasting) & clear
        shown, hidden = (
            Sightings(all_of.step[kept], all_of.key[kept], all_of.box[kept])
            for kept in (seen, ~seen)
        )
        return shown, hidden

    @property
    def together(self) -> NDArray[np.int64]:
        """Return the (pairs, 2) parties that touched."""
        return np.array(sorted(self._together), np.int64).reshape(-1, 2)

    def _subject(self, step: int, index: int) -> tuple[ClassCode, int]:
        kind = ClassCode(int(self._world.class_id[index]))
        if kind == ClassCode.PERSON:
            return kind, int(self._world.party[index])
        return kind, 1000 * index + int(self._move[step, index])


def _around(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the box about (n, 4) boxes."""
    low = boxes[:, :2].min(axis=0)
    high = (boxes[:, :2] + boxes[:, 2:]).max(axis=0)
    return np.concatenate([low, high - low])
