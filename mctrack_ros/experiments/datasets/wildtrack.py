"""WILDTRACK: seven cameras over a square, OpenPose detections, truth at 2 Hz."""

from __future__ import annotations

import json
import tarfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.experiments.datasets.social_pose import load_feet
from mctrack_ros.experiments.datasets.stored import Floats, StoredScene
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
        Which detections, as in `load_feet`.
    foot_sigma_px : float
        Standard deviation of a foot point, px.

    """
    stored_folder = folder / 'openpose_socialpose'
    detections = {}
    for camera in CAMERAS:
        feet = load_feet(stored_folder, camera, kind, IMAGE_SIZE, RATE, foot_sigma_px)
        detections[camera] = [_in_area(each) for each in feet[:FRAMES]]
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
    return Trajectories(frame=table[:, 0], id=table[:, 1], position=position_of(table[:, 2]))


def inside(position: Floats) -> NDArray[np.bool_]:
    """Tell which ground positions, (n, 2) m, lie in the annotated area."""
    (left, right), (low, high) = AREA
    x, y = position[:, 0], position[:, 1]
    within: NDArray[np.bool_] = (x >= left) & (x <= right) & (y >= low) & (y <= high)
    return within


def position_of(position_id: NDArray[np.int64]) -> Floats:
    """Return the (n, 2) ground positions, m, of positions' numbers."""
    return np.column_stack(
        [-3.0 + 0.025 * (position_id % 480), -9.0 + 0.025 * (position_id // 480)]
    )


def _in_area(detections: Detections) -> Detections:
    return detections.select(inside(detections.position[:, :2].astype(np.float64)))
