"""One camera's picture against the tracks: costs, assignment, update."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import Detections
from mctrack_ros.tracking.association import assign, mahalanobis
from mctrack_ros.tracking.kalman import position_matrix, symmetric, update

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

GROUP_INFLATION = 9.0
"""How much less a merged detection says about one of its members: factor of its covariance."""


def measured(detections: Detections, config: FusionConfig) -> tuple[Floats, Floats]:
    """Return the ground positions (m, 2), m, and covariances (m, 2, 2), m², to filter with."""
    noise = symmetric(detections.covariance.astype(np.float64))
    noise = noise + config.motion.sensor_sigma**2 * np.eye(2)
    return detections.position[:, :2].astype(np.float64), noise


def overlapped(box: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return which of the (n, 4) boxes (left, top, width, height, px) meet another one."""
    low, high = box[:, :2], box[:, :2] + box[:, 2:]
    meets = (low[:, None] < high[None]) & (low[None] < high[:, None])
    return np.asarray(meets.all(axis=2).sum(axis=1) > 1)


class CameraMatcher:
    """
    Associates one picture with the tracks and updates them.

    Tracks are at the tick's stamp; a detection measures where its track was ``seconds`` before
    (its own stamp is earlier), so no track is moved back.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp; changed in place.
    detections : Detections
        Usable rows of one picture.
    camera : int
        Index of the camera in the site's order.
    tick_ns : int
        The tick's stamp, ns.
    config : FusionConfig
        Parameters.

    """

    def __init__(
        self,
        table: TrackTable,
        detections: Detections,
        camera: int,
        tick_ns: int,
        config: FusionConfig,
    ) -> None:
        self.table, self.detections, self.camera, self.config = table, detections, camera, config
        seconds = (detections.stamp_ns - tick_ns) / 1e9
        self.matrix = position_matrix(seconds)
        self.position, self.noise = measured(detections, config)
        drift = config.motion.acceleration_density * abs(seconds) ** 3 / 3
        self.noise = self.noise + drift * np.eye(2)
        self.predicted = table.mean @ self.matrix.T
        self.spread = self.matrix @ table.covariance @ self.matrix.T
        self.is_single = detections.member_count == 1
        self.is_overlapped = overlapped(detections.box)

    def run(self) -> NDArray[np.intp]:
        """Associate and update; return the single detections that no track took."""
        single, groups = np.flatnonzero(self.is_single), np.flatnonzero(~self.is_single)
        rows, columns = assign(self.costs(single))
        taken = single[columns]
        self._update(rows, taken)
        free = np.ones(len(self.table), bool)
        free[rows] = False
        for group in groups:
            free[self._keep_members(int(group), free)] = False
        return np.setdiff1d(single, taken)

    def costs(self, columns: Indices) -> Floats:
        """
        Return the (n, m) costs of pairing each track with some of the detections.

        Minus twice the logarithm of the likelihood ratio of "this target's" against "nobody's",
        with priors for what the camera believes and for appearance; infinite outside the gate.
        """
        settings = self.config.association
        squared, log_determinant = mahalanobis(
            self.predicted, self.spread, self.position[columns], self.noise[columns]
        )
        cost = squared + log_determinant + 2 * np.log(2 * np.pi * settings.false_density)
        cost += np.where(self.table.confirmed, 0.0, settings.tentative_cost)[:, None]
        trust = np.where(self.is_overlapped[columns], settings.overlap_trust, 1.0)
        cost += settings.identity_bonus * trust * self._disbelief(columns)
        cost += settings.appearance_weight * self._difference(columns)
        return np.where(squared < settings.gate, cost, np.inf)

    def _disbelief(self, columns: Indices) -> Floats:
        """Return -1 where the camera takes the pair for one target, 1 for two, 0 unknown."""
        global_id = self.detections.track_id[columns]
        local_id = self.detections.local_id[columns]
        told = np.equal(self.table.track_id[:, None], global_id)
        remembered = np.equal(self.table.local_id[:, [self.camera]], local_id) & (local_id > 0)
        believed = np.where(told.any(axis=0), told, remembered)
        return np.where(believed, -1.0, believed.any(axis=0).astype(np.float64))

    def _difference(self, columns: Indices) -> Floats:
        """Return how much more than usual templates differ, 0 where one is not known."""
        ours = np.sqrt(np.maximum(self.table.template, 0))
        theirs = np.sqrt(np.maximum(self.detections.template[columns], 0))
        both: NDArray[np.bool_] = np.outer(ours.any(axis=1), theirs.any(axis=1))
        if not both.any():
            return np.zeros(both.shape)
        squared_hellinger = 1.0 - np.minimum(ours @ theirs.T, 1.0)
        return np.where(both, squared_hellinger - self.config.association.usual_difference, 0.0)

    def _update(self, rows: Indices, columns: Indices) -> None:
        if len(rows) == 0:
            return
        table, stamp_ns, camera = self.table, self.detections.stamp_ns, self.camera
        self._filter(rows, self.position[columns], self.noise[columns])
        self._learn_appearance(rows, columns)
        table.seen_ns[rows] = table.kept_ns[rows] = np.maximum(table.seen_ns[rows], stamp_ns)
        table.seen_by_ns[rows, camera] = stamp_ns
        table.local_id[rows, camera] = self.detections.local_id[columns]
        table.cameras[rows] |= np.uint32(1 << camera)
        for name in ('class_id', 'kit'):
            told = getattr(self.detections, name)[columns]
            known = getattr(table, name)
            known[rows] = np.where(told > 0, told, known[rows])

    def _filter(self, rows: Indices, position: Floats, noise: Floats) -> None:
        self.table.mean[rows], self.table.covariance[rows] = update(
            self.table.mean[rows],
            self.table.covariance[rows],
            position - self.predicted[rows],
            noise,
            self.matrix,
        )

    def _learn_appearance(self, rows: Indices, columns: Indices) -> None:
        template = self.detections.template[columns]
        told = template.any(axis=1) & ~self.is_overlapped[columns]
        rows, template = rows[told], template[told]
        known = self.table.template[rows]
        since = (self.detections.stamp_ns - self.table.seen_by_ns[rows, self.camera]) / 1e9
        weight = np.minimum(since / self.config.life.template_time, 0.5)
        weight = np.where(known.any(axis=1), weight, 1.0)[:, None]
        self.table.template[rows] = known + weight * (template - known)

    def _keep_members(self, group: int, free: NDArray[np.bool_]) -> Indices:
        """Keep alive what a merged detection hides; return the tracks."""
        table, detections = self.table, self.detections
        noise = self.noise[[group]] * GROUP_INFLATION
        squared, _ = mahalanobis(self.predicted, self.spread, self.position[[group]], noise)
        squared = squared[:, 0]
        named = np.isin(table.track_id, detections.members[group])
        candidates = np.flatnonzero(
            free & table.confirmed & (squared < self.config.association.gate)
        )
        order = np.lexsort((squared[candidates], ~named[candidates]))
        count = int(detections.member_count[group]) or len(candidates)
        members = np.sort(candidates[order[:count]])
        if len(members) == 0:
            return members
        position = np.repeat(self.position[[group]], len(members), axis=0)
        self._filter(members, position, np.repeat(noise, len(members), axis=0))
        stamp_ns = detections.stamp_ns
        table.kept_ns[members] = np.maximum(table.kept_ns[members], stamp_ns)
        table.group_ns[members] = table.hidden_ns[members, self.camera] = stamp_ns
        table.group[members] = table.track_id[members].min() if len(members) > 1 else 0
        return members
