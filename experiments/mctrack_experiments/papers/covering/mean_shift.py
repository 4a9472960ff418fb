"""The mean shift tracker with multi-target extension, on detections instead of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.covering.targets import Roster, Sight, beginnings
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.tracking.kalman import position_matrix, predict, update

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BANDWIDTH_M = 0.5
"""Standard deviation of the kernel on the ground, m."""
LEAST = 0.1
"""Density at a mode from which it supports its target; 1: a detection just there, its own."""
ROUNDS = 10


class MeanShiftTracker:
    """
    Every target climbs to the next mode of the detections' density and is measured there.

    Where the original weighs pixels by how well their colour fits the target (Comaniciu, Ramesh
    and Meer 2003, "Kernel-based object tracking"), all trackers here have the same detections:
    each is a Gaussian kernel on the ground, weighted by how alike its template and the target's
    are. The extension to several targets is that a detection counts for each in proportion to
    what it would be for it at the predicted place. Prediction and smoothing are a Kalman filter's,
    as in section 6.3 there.

    Parameters
    ----------
    config : JointConfig
        Its motion and its times.

    """

    def __init__(self, config: JointConfig) -> None:
        self._motion = config.motion
        self._roster = Roster(config.management)
        self._mean, self._covariance = np.empty((0, 4)), np.empty((0, 4, 4))

    def step(self, sight: Sight, seconds: float) -> tuple[Indices, Floats]:
        """Return the ids (n,) and places (n, 2), m, of those it stands for."""
        density = self._motion.acceleration_density
        self._mean, self._covariance = predict(self._mean, self._covariance, seconds, density)
        if len(self._roster) and len(sight.position):
            self._climb(sight, seconds)
        else:
            self._roster.count(
                np.zeros((len(self._roster), len(sight.position))), sight, LEAST, seconds
            )
        stays = self._roster.staying(self._mean[:, :2], seconds)
        self._mean, self._covariance = self._mean[stays], self._covariance[stays]
        self._begin(sight)
        reported = self._roster.is_told
        return self._roster.id[reported], self._mean[reported, :2]

    def _climb(self, sight: Sight, seconds: float) -> None:
        """Move every target to its mode and update it there."""
        weight = self._roster.alike(sight)
        own = weight * _kernel(self._mean[:, :2], sight.position)
        weight = weight * own / np.maximum(own.sum(axis=0), 1e-12)
        mode = self._mean[:, :2]
        for _ in range(ROUNDS):
            pull = weight * _kernel(mode, sight.position)
            total = pull.sum(axis=1, keepdims=True)
            mode = np.where(total > 1e-9, pull @ sight.position / np.maximum(total, 1e-9), mode)
        share = weight * _kernel(mode, sight.position)
        found = np.flatnonzero(share.sum(axis=1) >= LEAST)
        part = share[found] / share[found].sum(axis=1, keepdims=True)
        self._mean[found], self._covariance[found] = update(
            self._mean[found],
            self._covariance[found],
            mode[found] - self._mean[found, :2],
            np.einsum('nm,mij->nij', part, sight.noise),
            position_matrix(),
        )
        self._roster.count(share, sight, LEAST, seconds)

    def _begin(self, sight: Sight) -> None:
        rows = beginnings(sight, self._mean[:, :2])
        self._roster.begin(len(rows))
        mean, covariance = np.zeros((len(rows), 4)), np.zeros((len(rows), 4, 4))
        mean[:, :2], covariance[:, :2, :2] = sight.position[rows], sight.noise[rows]
        covariance[:, [2, 3], [2, 3]] = INITIAL_SPEED_SIGMA**2
        self._mean = np.append(self._mean, mean, axis=0)
        self._covariance = np.append(self._covariance, covariance, axis=0)


def _kernel(place: Floats, position: Floats) -> Floats:
    """Return the (n, m) Gaussian kernels, 1 at most."""
    square = ((place[:, None] - position) ** 2).sum(axis=2)
    return np.asarray(np.exp(-square / (2 * BANDWIDTH_M**2)))
