"""Kits: who is dressed alike, clustered without supervision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.tracking.appearance import squared_hellinger

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

MOST_CLUSTERS = 255
"""A kit is one byte, and 0 is unknown."""

DIFFERENCE = 0.2
"""Squared Hellinger distance of templates from which they are of different kits: chosen on the
tuning matches of the pitch."""

LEAST_AGE_S = 1.0
"""Age from which a track has a kit, s."""

CLUSTER_S = 10.0
"""Time constant of a kit, s."""

STEP_S = 0.5
"""Kits change slowly, and are looked at no more often, s."""

PROVEN_S = 2.0
"""A kit gets its number when it has been worn for so long, s."""

JOINED = 0.6
"""Kits join when they are so much nearer than what would be another's."""


class ClothingClusters:
    """
    Clusters of the tracks' templates: teams, and whoever is dressed otherwise.

    Means with a penalty for each further one (DP-means; Kulis and Jordan, "Revisiting k-means",
    2012) under the squared Hellinger distance, one round at a time: who is too far from every kit
    founds one, kits move slowly towards those who wear them, and two that have come close become
    one. How many there are is found; a kit keeps its number for good.
    """

    def __init__(self) -> None:
        self._centre: Floats = np.zeros((0, TEMPLATE_SIZE))
        self._number = np.zeros(0, np.uint8)
        self._worn_s = np.zeros(0)
        self._last = 0
        self._last_ns: int | None = None

    def step(self, table: TrackTable, stamp_ns: int) -> None:
        """
        Tell the tracks' kits, and learn from those that are seen and not in a group.

        Parameters
        ----------
        table : TrackTable
            ``kit`` is changed.
        stamp_ns : int
            The tick's stamp, ns.

        """
        seconds = STEP_S if self._last_ns is None else abs(stamp_ns - self._last_ns) / 1e9
        if seconds < STEP_S:
            return
        self._last_ns = stamp_ns
        old = stamp_ns - table.first_ns >= LEAST_AGE_S * 1e9
        alone = (table.cameras > 0) & (table.group == 0) & table.template.any(axis=1)
        rows = np.flatnonzero(table.confirmed & old & alone)
        if not len(rows):
            return
        template = table.template[rows].astype(np.float64)
        self._found(template)
        self._move(template, seconds)
        self._join(table)
        table.kit[rows] = self._worn(template, table.kit[rows])

    def _found(self, template: Floats) -> None:
        """Found kits until nobody is too far from all."""
        far = squared_hellinger(template, self._centre).min(axis=1, initial=1.0)
        while far.max() > DIFFERENCE and len(self._centre) < MOST_CLUSTERS:
            centre = template[[far.argmax()]]
            self._centre = np.vstack([self._centre, centre])
            self._number = np.append(self._number, np.uint8(0))
            self._worn_s = np.append(self._worn_s, 0.0)
            far = np.minimum(far, squared_hellinger(template, centre)[:, 0])

    def _move(self, template: Floats, seconds: float) -> None:
        """Move kits towards the mean of those who wear them; forget what was not proven."""
        nearest = squared_hellinger(template, self._centre).argmin(axis=1)
        worn = np.unique(nearest)
        self._worn_s[worn] = np.minimum(self._worn_s[worn] + seconds, CLUSTER_S)
        for index in worn.tolist():
            new = self._worn_s[index] < PROVEN_S
            rate = 1.0 if new else min(seconds / self._worn_s[index], 1.0)
            mean = template[nearest == index].mean(axis=0)
            self._centre[index] += rate * (mean - self._centre[index])
        kept = self._number > 0
        kept[worn] = True
        self._keep(kept)
        for index in np.flatnonzero((self._number == 0) & (self._worn_s >= PROVEN_S)).tolist():
            if self._last < MOST_CLUSTERS:
                self._last += 1
                self._number[index] = self._last

    def _join(self, table: TrackTable) -> None:
        """Let two kits that have come close become the older one."""
        gap = squared_hellinger(self._centre, self._centre)
        near = np.triu(gap < JOINED * DIFFERENCE, 1)
        near &= self._worn_s >= PROVEN_S
        if not near.any():
            return
        keep, drop = (int(index[0]) for index in np.nonzero(near))
        table.kit[table.kit == self._number[drop]] = self._number[keep]
        self._keep(np.arange(len(gap)) != drop)

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        self._centre, self._number = self._centre[kept], self._number[kept]
        self._worn_s = self._worn_s[kept]

    def _worn(self, template: Floats, before: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the nearest kits, or those worn before if they are hardly farther."""
        distance = squared_hellinger(template, self._centre)
        nearest = self._number[distance.argmin(axis=1)]
        same = (before[:, None] == self._number) & (before[:, None] > 0)
        own = np.where(same, distance, np.inf).min(axis=1)
        stays = own <= distance.min(axis=1) + DIFFERENCE / 2
        return np.where(stays | (nearest == 0), before, nearest).astype(np.uint8)
