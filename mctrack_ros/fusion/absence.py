"""Those who were lost, and whether a new track is one of them: prediction, time, colours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.portraits import Portraits
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.appearance import squared_hellinger
from mctrack_ros.tracking.kalman import predict

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Absent:
    """
    One who was lost.

    Attributes
    ----------
    stamp_ns : int
        When his track ended, ns.
    mean, covariance : (1, 4) and (1, 4, 4) arrays
        His state then.
    template : (1, 48) array
        His colours, of one picture after the other.

    """

    stamp_ns: int
    mean: Floats
    covariance: Floats
    template: NDArray[np.float32]


class Absence:
    """
    Finds those again whom no camera saw for a while.

    A new track is one of them if that is likelier than that somebody new came: where it is and
    how it moves, against where he would be by now had he gone on (so the time that he was away
    tells as much as the place), and what he looks like.

    Parameters
    ----------
    config : FusionConfig
        Parameters.
    portraits : Portraits
        What those who were seen alone look like; of others the latest templates tell it.

    Attributes
    ----------
    found : dict of int to float
        Who was found last, and at what cost: -2 log of how much likelier than somebody new.

    """

    def __init__(self, config: FusionConfig, portraits: Portraits) -> None:
        self._config = config
        self._portraits = portraits
        self._absent: dict[int, Absent] = {}
        self.found: dict[int, float] = {}

    def note(self, removed: TrackTable, row: int, stamp_ns: int) -> None:
        """Remember a track that ends."""
        state = (getattr(removed, name)[[row]] for name in ('mean', 'covariance', 'template'))
        self._absent[int(removed.track_id[row])] = Absent(stamp_ns, *state)

    def end(self, name: int) -> None:
        """One is back, or was never there."""
        self._absent.pop(name, None)

    def find(self, table: TrackTable, row: int, look: Floats, stamp_ns: int) -> int:
        """Return whom a new track that looks like (48,) most likely is; 0: somebody new."""
        longest_ns = self._config.recognition.lost_time * 1e9
        for name, one in list(self._absent.items()):
            if not 0 <= stamp_ns - one.stamp_ns <= longest_ns:
                self.end(name)
        costs = {
            name: self._motion_cost(table, row, one, (stamp_ns - one.stamp_ns) / 1e9)
            + self._colour_cost(name, one, table.template[[row]], look)
            for name, one in self._absent.items()
        }
        best = min(costs, key=costs.__getitem__, default=0)
        if best and costs[best] < 0:
            self.found[best] = costs[best]
            return best
        return 0

    def _motion_cost(self, table: TrackTable, row: int, absent: Absent, seconds: float) -> float:
        """Return -2 log of how much likelier he would be there, going so, than somebody new."""
        motion, mean = self._config.motion, table.mean[row]
        place, spread = predict(
            absent.mean, absent.covariance, seconds, motion.acceleration_density
        )
        change, spread = mean - place[0], spread[0] + table.covariance[row]
        his = change @ np.linalg.solve(spread, change) + np.linalg.slogdet(2 * np.pi * spread)[1]
        variance = motion.initial_speed_sigma**2
        new = mean[2:] @ mean[2:] / variance + 2 * np.log(2 * np.pi * variance)
        return float(his - new + 2 * np.log(self._config.recognition.arrival_density))

    def _colour_cost(
        self, name: int, absent: Absent, template: NDArray[np.float32], look: Floats
    ) -> float:
        """Return -2 log of how much likelier his colours are so than somebody else's."""
        association, strange = self._config.association, self._config.recognition.new
        if name in self._portraits and look.any():
            more = np.log1p(self._portraits.distance(look, name)) - np.log1p(strange)
        elif template.any() and absent.template.any():
            gap = squared_hellinger(template, absent.template)[0, 0]
            more = gap - association.usual_difference
        else:
            return 0.0
        return float(association.appearance_weight * more)
