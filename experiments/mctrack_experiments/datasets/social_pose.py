"""Social-Pose's files: foot detections by OpenPose and the calibrations that they come with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.io import loadmat

from mctrack_experiments.datasets.stored import feet_to_detections, stamp_of
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Detections

ANKLE_M = 0.08
"""
How high above the ground the lowest joints are that OpenPose knows, m: in any camera of WILDTRACK
the feet of frames 0 to 179 lie beyond the people nearest to them, within 1.2 m, as points 0.073 to
0.090 m up would (medians; once corrected and matched anew, up to 0.13 m).
"""


def load_feet(
    folder: Path,
    camera: str,
    kind: str,
    image_size: tuple[int, int],
    rate: float,
    foot_sigma_px: float,
) -> list[Detections]:
    """
    Load one camera's foot detections, on the ground below the ankles, one item an instant.

    Parameters
    ----------
    folder : Path
        With ``Calibration`` and ``Ground_Position_Detections``.
    camera : str
        Name of the camera.
    kind : str
        Which detections: ``basic_all``, ``basic_confirmed``, ``proposed_all`` or
        ``proposed_confirmed``.
    image_size : (int, int)
        Width and height of its images, px.
    rate : float
        Instants a second.
    foot_sigma_px : float
        Standard deviation of a foot point, px.

    """
    mapping = read_homography(folder / 'Calibration' / f'{camera}.mat', image_size)
    stored = loadmat(folder / 'Ground_Position_Detections' / f'{camera}.mat')
    return [
        feet_to_detections(
            np.asarray(cell, np.float64).reshape(-1, 2),
            mapping,
            stamp_of(index, rate),
            foot_sigma_px,
            height=ANKLE_M,
        )
        for index, cell in enumerate(stored[f'gp_uv_{kind}'][0])
    ]


def read_homography(path: Path, image_size: tuple[int, int]) -> ProjectiveMapping:
    """Read the homography of a camera, as a mapping to metres."""
    stored = loadmat(path)
    scale = 1 / float(stored['Scale'][0, 0])
    ground_from_image = np.diag([scale, scale, 1.0]) @ stored['H']
    return ProjectiveMapping.from_homography(np.linalg.inv(ground_from_image), image_size)
