"""Cameras whose detections lie off those of the others: corrected, and weighed down."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.sensor_bias.comparisons import MOST_TRACKS, REACH_M, compare
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import MEDIAN_SQUARED

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

LEAST_CAMERAS = 3
"""Of two that disagree nobody can say which is wrong."""
PAUSE_NS = 500_000_000
"""Cameras are compared no more often: the errors of images in succession are alike."""
KEPT = 128
"""Latest comparisons of a camera that count."""
INDEPENDENT = 0.5
"""Share of them that counts as independent."""
SURE = 3.0
"""Standard deviations by which a bias must stand out of chance."""
STILL_SURE = 1.0
"""As many for one that is known: no camera is doubted and believed by turns."""
NORMAL_MAD = 1.4826
"""Standard deviation over the median absolute deviation, of a normal distribution."""
MEDIAN_LOSS = np.sqrt(np.pi / 2)
"""Standard error of a median over that of a mean, of a normal distribution."""
BISECTIONS = 20


class CameraBias:
    """
    What is wrong with each camera, by what the others say of the same targets.

    A few times a second each camera's detections are held against what two or more others measure
    at the same time. A camera is believed while half of its residuals lie within the median that
    all the covariances promise, or no fewer than chance allows. From one that lies farther off the
    median residual is taken, as far as it stands out of its own chance; what is still beyond the
    promise then becomes a variance beside its own. Medians do not mind mistaken pairs, and no
    camera is believed more than it claims. The comparisons are between what cameras themselves
    say, not what they are corrected to, so corrections cannot drift together; one that is found
    wrong counts less as a witness. Beyond the papers.

    Parameters
    ----------
    cameras : int
        How many the site has; fewer than three are not judged.

    Attributes
    ----------
    offset : (cameras, 2) array
        What is taken from the places of each camera's detections, m.
    variance : (cameras,) array
        What is added to their variances, m².

    """

    def __init__(self, cameras: int) -> None:
        self.offset, self.variance = np.zeros((cameras, 2)), np.zeros(cameras)
        self._residual = [np.zeros((0, 2))] * cameras
        self._covariance = [np.zeros((0, 2, 2))] * cameras
        self._last_ns: int | None = None
        self._turn = 0

    def comparisons(self, camera: int) -> int:
        """Return by how many comparisons a camera is judged."""
        return len(self._residual[camera])

    def correct(self, batch: Batch) -> None:
        """Move the detections of a tick by what is known, and make them less certain."""
        if np.count_nonzero(self.offset) or np.count_nonzero(self.variance):
            batch.position -= self.offset[batch.camera]
            batch.noise[:, [0, 1], [0, 1]] += self.variance[batch.camera, None]

    def learn(
        self, table: TrackTable, batch: Batch, rows: Indices, columns: Indices, stamp_ns: int
    ) -> None:
        """
        Compare the cameras, if it is time to.

        Parameters
        ----------
        table : TrackTable
            The tracks at the tick.
        batch : Batch
            The tick's images, corrected.
        rows, columns : (k,) int arrays
            Tracks and the detections that are theirs.
        stamp_ns : int
            The tick's stamp, ns.

        """
        recent = self._last_ns is not None and abs(stamp_ns - self._last_ns) < PAUSE_NS
        if recent or len(self.variance) < LEAST_CAMERAS:
            return
        self._last_ns = stamp_ns
        apart = ~batch.is_overlapped[columns]
        seen = np.full((len(table), len(self.variance)), -1)
        seen[rows[apart], batch.camera[columns[apart]]] = columns[apart]
        position = batch.position + self.offset[batch.camera]
        noise = batch.noise - self.variance[batch.camera, None, None] * np.eye(2)
        doubt = self.variance + (self.offset**2).sum(axis=1)
        compared = compare(table.mean, seen, self._turn, batch, position, noise, doubt)
        self._turn += MOST_TRACKS
        self._keep(*compared)

    def _keep(self, camera: Indices, residual: Floats, covariance: Floats) -> None:
        """Add comparisons and judge the cameras anew that they are of."""
        for own in np.unique(camera).tolist():
            new = camera == own
            self._residual[own] = np.concatenate([self._residual[own], residual[new]])[-KEPT:]
            joined = np.concatenate([self._covariance[own], covariance[new]])
            self._covariance[own] = joined[-KEPT:]
            known = self.offset[own].any() or self.variance[own] > 0
            self.offset[own], self.variance[own] = judged(
                self._residual[own], self._covariance[own], STILL_SURE if known else SURE
            )


def _beyond(residual: Floats, covariance: Floats, offset: Floats, variance: float) -> int:
    """Count residuals beyond the median of what they should be, were bias and variance so."""
    x, y = (residual - offset).T
    xx, yy = covariance[:, 0, 0] + variance, covariance[:, 1, 1] + variance
    xy = covariance[:, 0, 1]
    squared = yy * x * x - 2 * xy * x * y + xx * y * y
    return int(np.count_nonzero(squared > MEDIAN_SQUARED * (xx * yy - xy * xy)))


def _offset(residual: Floats, sure: float) -> Floats:
    """Return the median residual, less what it may be by chance (James and Stein's way)."""
    middle: Floats = np.median(residual, axis=0)
    deviation = NORMAL_MAD * np.median(np.abs(residual - middle), axis=0)
    square = ((MEDIAN_LOSS * deviation) ** 2).sum() / (INDEPENDENT * len(residual)) / 2
    size = (middle**2).sum()
    return middle * max(1 - sure**2 * square / size, 0.0) if size > 0.0 else middle


def judged(residual: Floats, covariance: Floats, sure: float) -> tuple[Floats, float]:
    """
    Judge a camera by its residuals.

    Parameters
    ----------
    residual : (n, 2) array
        How its detections lie beside what others say, m.
    covariance : (n, 2, 2) array
        How they should, m².
    sure : float
        Standard deviations of chance by which they must fail to be so.

    Returns
    -------
    offset : (2,) array
        By which they lie off, m; nothing while the covariances explain what is seen.
    variance : float
        What they scatter by beside their covariances, m².

    """
    offset, count = np.zeros(2), len(residual)
    allowed = count / 2 + sure * np.sqrt(count / INDEPENDENT) / 2
    if _beyond(residual, covariance, offset, 0.0) <= allowed:
        return offset, 0.0
    offset = _offset(residual, sure)
    if _beyond(residual, covariance, offset, 0.0) <= allowed:
        return offset, 0.0
    low, high = 0.0, REACH_M**2
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if _beyond(residual, covariance, offset, middle) > allowed:
            low = middle
        else:
            high = middle
    return offset, high
