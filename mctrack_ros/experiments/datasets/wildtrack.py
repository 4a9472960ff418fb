"""WILDTRACK: seven cameras over a square, OpenPose detections, truth at 2 Hz."""

from __future__ import annotations

import json
import tarfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.experiments.datasets.stored import (
    Floats,
    StoredScene,
    feet_to_detections,
    stamp_of,
)
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Detections

RATE = 2.0
FRAMES = 360
"""Of the training split."""
CAMERAS = tuple(f'C{number}' for number in range(1, 8))
IMAGE_SIZE = (1920, 1080)
AREA = ((-3.0, 9.0), (-9.0, 27.0))
"""What is annotated: x and y, m."""


def load_wildtrack(folder: Path, kind: str, foot_sigma_px: float) -> StoredScene:
    """
    Load the training split with the foot detections of Social-Pose.

    Parameters
    ----------
    folder : Path
        Folder of the data set.
    kind : str
        Which detections: ``basic_all``, ``basic_confirmed``, ``proposed_all`` or
        ``proposed_confirmed``.
    foot_sigma_px : float
        Standard deviation of a foot point, px.

    """
    stored_folder = folder / 'openpose_socialpose'
    detections = {}
    for camera in CAMERAS:
        mapping = _mapping(stored_folder / 'Calibration' / f'{camera}.mat')
        feet = loadmat(stored_folder / 'Ground_Position_Detections' / f'{camera}.mat')
        detections[camera] = [
            _in_area(
                feet_to_detections(
                    np.asarray(cell, np.float64).reshape(-1, 2),
                    mapping,
                    stamp_of(index, RATE),
                    foot_sigma_px,
                )
            )
            for index, cell in enumerate(feet[f'gp_uv_{kind}'][0][:FRAMES])
        ]
    truth = read_truth(folder / 'annotations_positions_train.tar.gz')
    return StoredScene(np.arange(FRAMES), RATE, detections, truth)


def read_truth(path: Path) -> Trajectories:
    """Read the annotations; the fifth video picture is the second instant."""
    rows = []
    with tarfile.open(path) as archive:
        for member in archive.getmembers():
            file = archive.extractfile(member) if member.name.endswith('.json') else None
            if file is None:
                continue
            frame = int(Path(member.name).stem) // 5
            rows += [(frame, one['personID'], one['positionID']) for one in json.load(file)]
    table = np.array(rows, np.int64)
    return Trajectories(frame=table[:, 0], id=table[:, 1], position=_position_of(table[:, 2]))


def inside(position: Floats) -> NDArray[np.bool_]:
    """Tell which ground positions, (n, 2) m, lie in the annotated area."""
    (left, right), (low, high) = AREA
    x, y = position[:, 0], position[:, 1]
    within: NDArray[np.bool_] = (x >= left) & (x <= right) & (y >= low) & (y <= high)
    return within


def _position_of(position_id: NDArray[np.int64]) -> Floats:
    return np.column_stack(
        [-3.0 + 0.025 * (position_id % 480), -9.0 + 0.025 * (position_id // 480)]
    )


def _in_area(detections: Detections) -> Detections:
    return detections.select(inside(detections.position[:, :2].astype(np.float64)))


def _mapping(path: Path) -> ProjectiveMapping:
    stored = loadmat(path)
    scale = 1 / float(stored['Scale'][0, 0])
    ground_from_image = np.diag([scale, scale, 1.0]) @ stored['H']
    return ProjectiveMapping.from_homography(np.linalg.inv(ground_from_image), IMAGE_SIZE)
