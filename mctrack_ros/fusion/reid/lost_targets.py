"""Lost targets, and which of them a new track is: by prediction, time away and colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.fusion.reid.appearance import AppearanceModel
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.appearance import squared_hellinger
from mctrack_ros.tracking.kalman import predict

Floats = NDArray[np.float64]
Templates = NDArray[np.float32]

ARRIVAL_DENSITY = 0.001
"""How likely somebody new comes into view where one who was lost may, 1/m²: chosen on scenarios of
people who cross a gap (`mctrack reproduce scenarios`)."""

NEW = 2.5
"""What colours differ by that speak neither for nor against, in variances of one person's: chosen
on the tuning matches of the pitch."""

MOST_LOST = 100
"""Number of targets that are remembered, those who were lost last."""

SPEED = 3.0
"""How fast a lost target may have gone on, m/s: a run."""


class LostTargets:
    """
    Targets that no track has any more, each with the last record of its track.

    A target stays for `reid.lost_time` after it was lost, unless it is found or `MOST_LOST`
    others were lost since. A new track is a lost target if that is likelier than a new one: by its
    state against the predicted one (so the time away counts as well as the place) and by colours.

    Parameters
    ----------
    config : JointConfig
        Parameters.
    model : AppearanceModel
        How much targets differ from themselves.

    Attributes
    ----------
    tracks : TrackTable
        Their records.
    found : dict of int to float
        Who was found last, and at what cost: -2 log of how much likelier than a new target.

    """

    def __init__(self, config: JointConfig, model: AppearanceModel) -> None:
        self._config = config
        self._model = model
        self.tracks = TrackTable.blank(0, 0)
        self._lost_ns = np.zeros(0, np.int64)
        self.found: dict[int, float] = {}

    def add(self, tracks: TrackTable, stamp_ns: int) -> list[int]:
        """Remember tracks that end; return the ids that are dropped for want of room."""
        lost = self.tracks.extended(tracks)
        dropped: list[int] = lost.track_id[:-MOST_LOST].tolist()
        self.tracks = lost.select(np.arange(len(lost))[-MOST_LOST:])
        since = np.full(len(tracks), stamp_ns)
        self._lost_ns = np.append(self._lost_ns, since)[-MOST_LOST:]
        return dropped

    def remove(self, track_id: int) -> None:
        """Forget a target: it is back, or never existed."""
        self._keep(self.tracks.track_id != track_id)

    def expire(self, stamp_ns: int) -> list[int]:
        """Forget those lost too long ago, or after this stamp; return their ids."""
        age_ns = stamp_ns - self._lost_ns
        kept = (age_ns >= 0) & (age_ns <= self._config.reid.lost_time * 1e9)
        expired: list[int] = self.tracks.track_id[~kept].tolist()
        self._keep(kept)
        return expired

    def lately(self, stamp_ns: int, seconds: float) -> tuple[Floats, Floats]:
        """Return where those lost within so many seconds were, (k, 2) m, and how long ago, s."""
        ago_s = (stamp_ns - self._lost_ns) / 1e9
        late = (ago_s >= 0) & (ago_s <= seconds)
        return self.tracks.mean[late, :2], ago_s[late]

    def near(self, place: Floats, stamp_ns: int) -> list[int]:
        """Return the ids of those seen alone before who can have come to a place (2,), m."""
        apart = np.hypot(*(self.tracks.mean[:, :2] - place).T)
        reach = self.reach(stamp_ns - self.tracks.seen_ns)
        near: list[int] = self.tracks.track_id[
            (apart < reach) & (self.tracks.gallery_s > 0.0)
        ].tolist()
        return near

    def reach(self, since_ns: NDArray[np.int64]) -> Floats:
        """Return how far targets have gone at most that were seen so long ago, m."""
        return np.asarray(self._config.reid.contact_distance + SPEED * since_ns * 1e-9)

    def find(self, table: TrackTable, row: int, sample: Floats, stamp_ns: int) -> int:
        """Return whom a new track with a sample (48,) most likely is; 0: somebody new."""
        costs = self._motion_costs(table, row, stamp_ns)
        for index in np.flatnonzero(costs < self._most_alike()).tolist():
            costs[index] += self._colour_cost(index, table.template[[row]], sample)
        best = int(costs.argmin()) if len(costs) else 0
        if not len(costs) or costs[best] >= 0:
            return 0
        name = int(self.tracks.track_id[best])
        self.found[name] = float(costs[best])
        return name

    def give_gallery(self, track_id: int, table: TrackTable, row: int) -> None:
        """Give a track the gallery of the lost target that it is."""
        (own,) = np.flatnonzero(self.tracks.track_id == track_id)
        table.gallery[row], table.gallery_s[row] = (
            self.tracks.gallery[own],
            self.tracks.gallery_s[own],
        )

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        if not kept.all():
            self.tracks, self._lost_ns = self.tracks.select(kept), self._lost_ns[kept]

    def _motion_costs(self, table: TrackTable, row: int, stamp_ns: int) -> Floats:
        """Return -2 log, (k,), of how much likelier each would be there, going so, than a new."""
        motion, mean, lost = self._config.motion, table.mean[row], self.tracks
        seconds = (stamp_ns - self._lost_ns) / 1e9
        his = _unlikely(
            lost.mean,
            lost.covariance,
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

    def _colour_cost(self, index: int, template: Templates, sample: Floats) -> float:
        """Return -2 log of how much likelier his colours are so than somebody else's."""
        association, last = self._config.association, self.tracks.template[[index]]
        if self.tracks.gallery_s[index] > 0.0 and sample.any():
            gallery = self.tracks.gallery[[index]]
            more = np.log1p(self._model.distances(sample[None], gallery)[0, 0]) - np.log1p(NEW)
        elif template.any() and last.any():
            more = squared_hellinger(template, last)[0, 0] - association.usual_difference
        else:
            return 0.0
        return float(association.appearance_weight * more)


def _unlikely(
    mean: Floats, covariance: Floats, seconds: Floats, density: float, seen: Floats, spread: Floats
) -> Floats:
    """Return -2 log, (k,), of how likely states are, so much later, the one that is seen."""
    there, sure = predict(mean, covariance, seconds, density)
    there, sure = seen - there, sure + spread
    sign, size = np.linalg.slogdet(sure)
    usable = sign > 0
    cost = np.full(len(mean), np.inf)
    apart = np.linalg.solve(sure[usable], there[usable, :, None])[..., 0]
    cost[usable] = 4 * np.log(2 * np.pi) + size[usable] + (there[usable] * apart).sum(axis=1)
    return cost
