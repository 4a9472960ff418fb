"""Those who were lost, and whether a new track is one of them: prediction, time, colours."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_1D, COLUMN_2D, COLUMN_3D, FLOATS_1D, compiled
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.motion.information import invert
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.fusion.reid.gallery import Gallery
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.appearance import squared_hellinger
from mctrack_ros.tracking.kalman import moved_on

Floats = NDArray[np.float64]

ARRIVAL_DENSITY = 0.001
"""How likely somebody new comes into view where one who was lost may, 1/m²: chosen on scenarios of
people who cross a gap (`mctrack reproduce scenarios`)."""

NEW = 2.5
"""What colours differ by that speak neither for nor against, in variances of one person's: chosen
on the tuning matches of the pitch."""

MOST_ABSENT = 100
"""So many are remembered, those who were lost last."""


class ReEntry:
    """
    Finds those again whom no camera saw for a while.

    A new track is one of them if that is likelier than that somebody new came: where it is and
    how it moves, against where he would be by now had he gone on (so the time that he was away
    tells as much as the place), and what he looks like.

    Parameters
    ----------
    config : JointConfig
        Parameters.
    gallery : Gallery
        What those who were seen alone look like; of others the latest templates tell it.

    Attributes
    ----------
    found : dict of int to float
        Who was found last, and at what cost: -2 log of how much likelier than somebody new.

    """

    def __init__(self, config: JointConfig, gallery: Gallery) -> None:
        self._config = config
        self._gallery = gallery
        self._absent = TrackTable.blank(0, 0)
        self._ended_ns = np.zeros(0, np.int64)
        self.found: dict[int, float] = {}

    def note(self, ended: TrackTable, stamp_ns: int) -> None:
        """Remember tracks that end."""
        if len(self._absent):
            ended = self._absent.extended(ended)
        self._absent = ended.select(np.arange(len(ended))[-MOST_ABSENT:])
        since = np.full(len(ended) - len(self._ended_ns), stamp_ns)
        self._ended_ns = np.append(self._ended_ns, since)[-MOST_ABSENT:]

    def end(self, name: int) -> None:
        """One is back, or was never there."""
        self._keep(self._absent.track_id != name)

    def lately(self, stamp_ns: int, seconds: float) -> tuple[Floats, Floats]:
        """Return where those lost within so many seconds were, (k, 2) m, and how long ago, s."""
        ago_s = (stamp_ns - self._ended_ns) / 1e9
        late = (ago_s >= 0) & (ago_s <= seconds)
        return self._absent.mean[late, :2], ago_s[late]

    def find(self, table: TrackTable, row: int, look: Floats, stamp_ns: int) -> int:
        """Return whom a new track that looks like (48,) most likely is; 0: somebody new."""
        age_ns = stamp_ns - self._ended_ns
        self._keep((age_ns >= 0) & (age_ns <= self._config.recognition.lost_time * 1e9))
        costs = self._motion_costs(table, row, stamp_ns)
        for index in np.flatnonzero(costs < self._most_alike()).tolist():
            costs[index] += self._colour_cost(index, table.template[[row]], look)
        best = int(costs.argmin()) if len(costs) else 0
        if not len(costs) or costs[best] >= 0:
            return 0
        name = int(self._absent.track_id[best])
        self.found[name] = float(costs[best])
        return name

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        if not kept.all():
            self._absent, self._ended_ns = self._absent.select(kept), self._ended_ns[kept]

    def _motion_costs(self, table: TrackTable, row: int, stamp_ns: int) -> Floats:
        """Return -2 log, (k,), of how much likelier each would be there, going so, than a new."""
        motion, mean, absent = self._config.motion, table.mean[row], self._absent
        seconds = (stamp_ns - self._ended_ns) / 1e9
        his = _unlikely(
            absent.mean,
            absent.covariance,
            seconds,
            motion.acceleration_density,
            mean,
            table.covariance[row],
        )
        variance = INITIAL_SPEED_SIGMA**2
        new = mean[2:] @ mean[2:] / variance + 2 * np.log(2 * np.pi * variance)
        arrival = 2 * np.log(ARRIVAL_DENSITY)
        return np.asarray(his - new + arrival, np.float64)

    def _most_alike(self) -> float:
        """Return what colours can be worth at most."""
        association = self._config.association
        best = max(float(np.log1p(NEW)), association.usual_difference)
        return association.appearance_weight * best

    def _colour_cost(self, index: int, template: NDArray[np.float32], look: Floats) -> float:
        """Return -2 log of how much likelier his colours are so than somebody else's."""
        association = self._config.association
        name, last = int(self._absent.track_id[index]), self._absent.template[[index]]
        if name in self._gallery and look.any():
            more = np.log1p(self._gallery.distance(look, name)) - np.log1p(NEW)
        elif template.any() and last.any():
            more = squared_hellinger(template, last)[0, 0] - association.usual_difference
        else:
            return 0.0
        return float(association.appearance_weight * more)


@compiled(types.f8[::1](COLUMN_2D, COLUMN_3D, FLOATS_1D, types.f8, COLUMN_1D, COLUMN_2D))
def _unlikely(
    mean: Floats, covariance: Floats, seconds: Floats, density: float, seen: Floats, spread: Floats
) -> Floats:
    """Return -2 log, (k,), of how likely states are, so much later, the one that is seen."""
    cost = np.full(len(mean), np.inf)
    there, sure, weight = np.empty(4), np.empty((4, 4)), np.empty((4, 4))
    for row in range(len(mean)):
        moved_on(mean[row], covariance[row], seconds[row], density, there, sure)
        for i in range(4):
            there[i] = seen[i] - there[i]
            for j in range(4):
                sure[i, j] += spread[i, j]
        certainty = invert(sure, weight)
        if not certainty > 0.0:
            continue
        cost[row] = 4 * np.log(2 * np.pi) - np.log(certainty)
        for i in range(4):
            for j in range(4):
                cost[row] += there[i] * weight[i, j] * there[j]
    return cost
