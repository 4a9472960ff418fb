"""What filtering alone can reach: a Kalman filter that is told whose every detection is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mctrack_experiments.bench.fusion.adapter import Reported
from mctrack_experiments.bench.fusion.toolkit import Scene
from mctrack_ros.tracking.kalman import position_matrix, predict, update

ACCELERATION_DENSITY = 2.0
"""Power spectral density of the targets' acceleration, m²/s³."""

SPEED_SIGMA = 3.0
"""Standard deviation of their first velocity, m/s."""


class TrueAssociation:
    """
    Starts at the true positions and updates each target with the detections it caused.

    Of a detection that two have merged into the nearer one gets the update.

    Parameters
    ----------
    scene : Scene
        Its truth and its detections.

    """

    def __init__(self, scene: Scene) -> None:
        self._fields, self._scenario = scene.fields, scene.scenario
        self._mean = np.pad(scene.scenario.truth[0], ((0, 0), (0, 2)))
        variance = np.diag([0.01, 0.01, SPEED_SIGMA**2, SPEED_SIGMA**2])
        self._covariance = np.tile(variance, (len(self._mean), 1, 1))

    def prepare(self, frame: int) -> None:
        """Do nothing."""

    def step(self, frame: int) -> Reported:
        """Process a tick."""
        self._mean, self._covariance = predict(
            self._mean, self._covariance, self._scenario.tick_s, ACCELERATION_DENSITY
        )
        cameras = self._scenario.cameras
        bounds = self._fields['pointer'][frame * cameras : (frame + 1) * cameras + 1].tolist()
        for first, last in pairwise(bounds):
            self._update(slice(first, last))
        return list(range(len(self._mean))), self._mean[:, :2].copy()

    def _update(self, rows: slice) -> None:
        """Take in what one camera saw of the targets."""
        target = self._fields['detection_target'][rows]
        known, target = target >= 0, target[target >= 0]
        self._mean[target], self._covariance[target] = update(
            self._mean[target],
            self._covariance[target],
            self._fields['detection_position'][rows][known] - self._mean[target, :2],
            self._fields['detection_covariance'][rows][known],
            position_matrix(),
        )
