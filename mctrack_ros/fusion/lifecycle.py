"""When tracks are confirmed, hidden, merged and deleted; all in seconds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.coverage import CoverageMap
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable

GROUP_MEMORY_S = 0.2
"""A track has left its group when no camera has seen it in one for so long, s."""

Mask = NDArray[np.bool_]


class Evidence:
    """
    Weighs what the cameras see of each track against what they should see.

    Parameters
    ----------
    cameras : int
        How many there are.
    config : FusionConfig
        Parameters.

    """

    def __init__(self, cameras: int, config: FusionConfig) -> None:
        self._life = config.life
        life = config.life
        self._coverage = CoverageMap(cameras, life.coverage_cell, life.coverage_prior)

    def count(self, table: TrackTable, tick_ns: int, seconds: float, present: Mask) -> Mask:
        """
        Add one tick's evidence to the log-odds, and confirm.

        Misses speak only against what one camera alone sees: what two see is real, and what none
        sees is left to the time it may coast. What a camera sees in a group it does not miss.

        Parameters
        ----------
        table : TrackTable
            Changed in place.
        tick_ns : int
            The tick's stamp, ns.
        seconds : float
            Time since the last tick, s.
        present : (cameras,) bool array
            Whose pictures are in the tick.

        Returns
        -------
        (n,) bool array
            The newly confirmed.

        """
        life = self._life
        seen = (table.cameras[:, None] >> np.arange(len(present), dtype=np.uint32) & 1).astype(
            bool
        )
        begin_ns = tick_ns - round(seconds * 1e9)
        watched = present & ~((table.hidden_ns > begin_ns) & ~seen)
        position = table.mean[:, :2]
        miss = np.log1p(-self._coverage.probability(position))
        look = min(seconds / life.look_time, 1.0)
        alone = seen.sum(axis=1, keepdims=True) == 1
        weight = np.where(table.confirmed, life.miss_weight, 1.0)[:, None]
        gain = np.where(seen, life.hit_evidence, weight * miss * (watched & alone))
        table.evidence += look * np.where(seen.any(axis=1), gain.sum(axis=1), 0.0)
        table.evidence = np.clip(table.evidence, -life.most_evidence, life.most_evidence)
        confirmed = ~table.confirmed & (table.evidence >= life.confirm_evidence)
        table.confirmed |= confirmed
        by_others = seen.sum(axis=1, keepdims=True) - seen > 0
        sure = table.confirmed
        self._coverage.learn(
            position[sure],
            seen[sure],
            (watched & by_others)[sure],
            min(seconds, life.look_time),
        )
        return confirmed


def doubt_parts(fresh: TrackTable, table: TrackTable, config: FusionConfig) -> None:
    """Ask more evidence of new tracks that begin beside a confirmed one: blobs fall apart."""
    old = table.mean[table.confirmed, :2]
    gap = np.linalg.norm(fresh.mean[:, None, :2] - old[None], axis=2)
    beside = (gap < config.life.crowd_distance).any(axis=1)
    fresh.evidence[beside] -= config.life.crowd_evidence


def silence(table: TrackTable, stamp_ns: int) -> NDArray[np.float64]:
    """Return for how long, (n,) s, nothing has supported each track."""
    return (stamp_ns - table.kept_ns) / 1e9


def is_over(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that end now."""
    life = config.life
    limit = np.where(table.confirmed, life.coast_time, life.tentative_time)
    silent = silence(table, stamp_ns) > np.maximum(limit, 1.5 * config.batching.period)
    return silent | (table.confirmed & (table.evidence < 0))


def is_published(table: TrackTable, stamp_ns: int, config: FusionConfig) -> Mask:
    """Return the mask of the tracks that are told to others, not only remembered."""
    limit = max(config.life.report_time, 1.5 * config.batching.period)
    return silence(table, stamp_ns) <= limit


def leave_groups(table: TrackTable, stamp_ns: int) -> None:
    """Forget the group of what has not been seen in one for a while."""
    table.group[stamp_ns - table.group_ns > GROUP_MEMORY_S * 1e9] = 0


class DuplicateWatch:
    """Notices two tracks that follow one target: near for a while, told apart by no camera."""

    def __init__(self, config: FusionConfig) -> None:
        self._distance = config.life.merge_distance
        self._time_ns = round(config.life.merge_time * 1e9)
        self._since_ns: dict[tuple[int, int], int] = {}

    def find(self, table: TrackTable, stamp_ns: int) -> list[tuple[int, int]]:
        """Return pairs of rows (kept, dropped) that are one target by now."""
        near = [
            (int(table.track_id[one]), int(table.track_id[other]), one, other)
            for one, other in self._near_pairs(table, stamp_ns)
        ]
        self._since_ns = {pair[:2]: self._since_ns.get(pair[:2], stamp_ns) for pair in near}
        due = [
            (one, other)
            for first, second, one, other in near
            if stamp_ns - self._since_ns[first, second] >= self._time_ns
        ]
        chosen, used = [], set[int]()
        for one, other in due:
            if not used & {one, other}:
                used |= {one, other}
                newer_is_better = table.confirmed[other] and not table.confirmed[one]
                chosen.append((other, one) if newer_is_better else (one, other))
        return chosen

    def _near_pairs(self, table: TrackTable, stamp_ns: int) -> list[tuple[int, int]]:
        gap = table.mean[:, None, :2] - table.mean[None, :, :2]
        near = np.triu((gap**2).sum(axis=2) < self._distance**2, 1)
        one, other = np.nonzero(near)
        recent_ns = stamp_ns - self._time_ns
        both = np.minimum(table.seen_by_ns[one], table.seen_by_ns[other]) > recent_ns
        unresolved = ~both.any(axis=1) & (table.group[one] == 0) & (table.group[other] == 0)
        return list(zip(one[unresolved].tolist(), other[unresolved].tolist()))


def absorb(table: TrackTable, kept: int, dropped: int) -> None:
    """Give a track what is known of its duplicate."""
    newer = table.seen_by_ns[dropped] > table.seen_by_ns[kept]
    table.local_id[kept] = np.where(newer, table.local_id[dropped], table.local_id[kept])
    table.seen_by_ns[kept] = np.maximum(table.seen_by_ns[kept], table.seen_by_ns[dropped])
    for name in ('seen_ns', 'kept_ns', 'evidence'):
        values = getattr(table, name)
        values[kept] = max(values[kept], values[dropped])
    table.cameras[kept] |= table.cameras[dropped]
    if np.trace(table.covariance[dropped]) < np.trace(table.covariance[kept]):
        table.mean[kept] = table.mean[dropped]
        table.covariance[kept] = table.covariance[dropped]
    if not table.template[kept].any():
        table.template[kept] = table.template[dropped]
    table.previous_id[kept] = table.track_id[dropped]
