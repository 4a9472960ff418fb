"""Pictures of one tick, ready for association."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.interfaces import Detections
from mctrack_ros.tracking.kalman import position_matrix, symmetric

Floats = NDArray[np.float64]


class Look:
    """
    One picture's usable detections, as measurements.

    Tracks are at the tick's stamp; a detection measures where its track was a little before (its
    own stamp is earlier), so no track is moved back.

    Parameters
    ----------
    detections : Detections
        Usable rows of one picture.
    camera : int
        Index of the camera in the site's order.
    tick_ns : int
        The tick's stamp, ns.
    config : FusionConfig
        Parameters.

    Attributes
    ----------
    single, groups : (k,) int arrays
        Rows of ordinary detections, and of those that stand for several targets.
    matrix : (2, 4) array
        From a track's state at the tick to its position in the picture.
    position : (m, 2) array
        Where the detections are, m.
    noise : (m, 2, 2) array
        Their covariances, m².
    is_overlapped : (m,) bool array
        Whose box meets another one.

    """

    def __init__(
        self, detections: Detections, camera: int, tick_ns: int, config: FusionConfig
    ) -> None:
        self.detections, self.camera = detections, camera
        is_single = detections.member_count == 1
        self.single, self.groups = np.flatnonzero(is_single), np.flatnonzero(~is_single)
        seconds = (detections.stamp_ns - tick_ns) / 1e9
        self.matrix = position_matrix(seconds)
        self.position, noise = measured(detections, config)
        drift = config.motion.acceleration_density * abs(seconds) ** 3 / 3
        self.noise = noise + drift * np.eye(2)
        self.is_overlapped = overlapped(detections.box)


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
