"""What the trackers of comparison have in common: what they are given, who begins, who ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.measurements.admission import Admitted
from mctrack_ros.fusion.reid.appearance import TEMPLATE_S
from mctrack_ros.interfaces import Tick
from mctrack_ros.tracking.appearance import squared_hellinger

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Templates = NDArray[np.float32]

CONFIRMED_S = 0.5
"""A target is told of when it has been supported for so long, s."""
BEGIN_M, BEGIN_SIGMA = 1.25, 3.5
"""What is farther from every target begins one: m, and standard deviations of its place."""
MERGE_M, MERGE_S = 0.4, 2.0
"""Two that have been nearer for so long, m and s, are one: the elder."""
ALIKE = 0.1
"""Squared Hellinger distance of templates at which they are alike by a factor e less."""


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """
    All detections of one tick.

    Attributes
    ----------
    position : (m, 2) array
        m.
    noise : (m, 2, 2) array
        Covariances, with what every detection has beside its own, m².
    template : (m, 48) float32 array
        Appearance.
    image : (m,) int64 array
        Which image each is in.
    single : (m,) bool array
        Which are one target each.

    """

    position: Floats
    noise: Floats
    template: Templates
    image: Indices
    single: Mask

    @classmethod
    def of(cls, tick: Tick, config: JointConfig) -> Sight:
        """Return what a tick shows."""
        images = [each.rows for each in tick.messages]
        count = len(images)
        all_of = Admitted(images, range(count), [config.motion.sensor_sigma**2] * count)
        return cls(
            all_of.place,
            all_of.noise,
            all_of.template,
            all_of.image,
            all_of.is_single,
        )


class PointTracker(Protocol):
    """A whole tracker, small: what a tick shows in, ids and places out."""

    def step(self, sight: Sight, seconds: float) -> tuple[Indices, Floats]:
        """Return the ids (n,) and places (n, 2), m, of those it stands for."""
        ...


class Roster:
    """
    Who there is: begins, is told of when supported for a while, ends without support.

    Parameters
    ----------
    management : ManagementConfig
        Fusion's own times.

    Attributes
    ----------
    id : (n,) int64 array
    template : (n, 48) float32 array

    """

    def __init__(self, management: ManagementConfig) -> None:
        self._management, self._next = management, 1
        self.id = np.empty(0, np.int64)
        self.template = np.empty((0, 48), np.float32)
        self._supported_s, self._silent_s = np.empty(0), np.empty(0)
        self._together_s = np.empty((0, 0))

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.id)

    @property
    def is_told(self) -> Mask:
        """Return who (n,) is told of."""
        return self._confirmed & (self._silent_s <= self._management.report_time)

    @property
    def _confirmed(self) -> Mask:
        return self._supported_s >= CONFIRMED_S

    def alike(self, sight: Sight) -> Floats:
        """Return how alike (n, m) targets and detections are, 1 at most and where unknown."""
        known = np.asarray(self.template.any(axis=1))[:, None] & sight.template.any(axis=1)
        change = squared_hellinger(self.template, sight.template)
        return np.where(known, np.exp(-change / ALIKE), 1.0)

    def count(self, share: Floats, sight: Sight, least: float, seconds: float) -> None:
        """Note by how much (n, m) detections support targets, and what these look like."""
        total = share.sum(axis=1)
        supported = total >= least
        self._supported_s += np.where(supported, seconds, 0.0)
        self._silent_s = np.where(supported, 0.0, self._silent_s + seconds)
        share = share * sight.template.any(axis=1)
        clear = np.flatnonzero(share.max(axis=1, initial=0.0) >= least)
        seen = share[clear] @ sight.template / share[clear].sum(axis=1, keepdims=True)
        known = self.template[clear].any(axis=1)
        rate = np.where(known, min(seconds / TEMPLATE_S, 0.5), 1.0)[:, None]
        self.template[clear] += (rate * (seen - self.template[clear])).astype(np.float32)

    def staying(self, place: Floats, seconds: float) -> Mask:
        """Drop who ends, being at (n, 2) places, and return who (n,) stays."""
        limit = np.where(
            self._confirmed, self._management.coast_time, self._management.tentative_time
        )
        near = np.linalg.norm(place[:, None] - place, axis=2) < MERGE_M
        self._together_s = np.where(near, self._together_s + seconds, 0.0)
        doubled = np.tril(self._together_s >= MERGE_S, -1).any(axis=1)
        stays: Mask = np.asarray((self._silent_s <= limit) & ~doubled)
        self._together_s = self._together_s[np.ix_(stays, stays)]
        self.id, self.template = self.id[stays], self.template[stays]
        self._supported_s = self._supported_s[stays]
        self._silent_s = self._silent_s[stays]
        return stays

    def begin(self, count: int) -> None:
        """Add so many of whom nothing is known."""
        self.id = np.append(self.id, np.arange(self._next, self._next + count))
        self._next += count
        self.template = np.append(self.template, np.zeros((count, 48), np.float32), axis=0)
        self._supported_s = np.append(self._supported_s, np.zeros(count))
        self._silent_s = np.append(self._silent_s, np.zeros(count))
        self._together_s = np.pad(self._together_s, (0, count))


def beginnings(sight: Sight, place: Floats) -> Indices:
    """Return the single detections (k,) that begin targets: far from all places (n, 2)."""
    sigma = np.sqrt(np.trace(sight.noise, axis1=1, axis2=2) / 2)
    reach = np.maximum(BEGIN_M, BEGIN_SIGMA * sigma)
    found: list[int] = []
    for row in np.flatnonzero(sight.single).tolist():
        near = np.vstack([place, sight.position[found]])
        if (np.linalg.norm(near - sight.position[row], axis=1) > reach[row]).all():
            found.append(row)
    return np.array(found, np.int64)
