"""WILDTRACK: seven cameras over a square, OpenPose detections, boxes and truth at 2 Hz."""

from __future__ import annotations

import json
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.social_pose import load_feet
from mctrack_experiments.datasets.stored import (
    Floats,
    StoredScene,
    cut_to,
    feet_to_detections,
    stamp_of,
)
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import GroundMapping, read_calibration

RATE = 2.0
FRAMES = 360
"""Of the training split."""
CAMERAS = tuple(f'C{number}' for number in range(1, 8))
CALIBRATIONS = ('CVLab1', 'CVLab2', 'CVLab3', 'CVLab4', 'IDIAP1', 'IDIAP2', 'IDIAP3')
"""What the files of their calibrations are called."""
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
        detections[camera] = [cut_to(each, AREA) for each in feet[:FRAMES]]
    return StoredScene(np.arange(FRAMES), RATE, detections, read_truth(folder))


def load_wildtrack_boxes(folder: Path, foot_sigma_px: float) -> StoredScene:
    """
    Load the training split with its annotated boxes as detections: a perfect detector's.

    Parameters
    ----------
    folder : Path
        Folder of the data set.
    foot_sigma_px : float
        Standard deviation of a box's lower edge, px.

    """
    feet: list[list[list[tuple[float, float]]]]
    feet = [[[] for _ in range(FRAMES)] for _ in CAMERAS]
    for frame, index, column, row, _ in annotated_feet(folder):
        feet[index][frame].append((column, row))
    detections = {}
    for index, camera in enumerate(CAMERAS):
        mapping = read_mapping(folder, index)
        detections[camera] = [
            cut_to(
                feet_to_detections(
                    # by place in the image: their order must not tell who is who
                    np.array(sorted(each), np.float64).reshape(-1, 2),
                    mapping,
                    stamp_of(frame, RATE),
                    foot_sigma_px,
                ),
                AREA,
            )
            for frame, each in enumerate(feet[index])
        ]
    return StoredScene(np.arange(FRAMES), RATE, detections, read_truth(folder))


def read_mapping(folder: Path, camera: int) -> GroundMapping:
    """Read the calibration of a camera, by its index, of images without distortion."""
    name, calibrations = CALIBRATIONS[camera], folder / 'calibrations'
    return read_calibration(
        calibrations / 'intrinsic_zero' / f'intr_{name}.xml',
        IMAGE_SIZE,
        calibrations / 'extrinsic' / f'extr_{name}.xml',
        'cm',
    )


def read_truth(folder: Path) -> Trajectories:
    """Read who was where."""
    rows = [(frame, one['personID'], one['positionID']) for frame, one in _annotated(folder)]
    table = np.array(rows, np.int64)
    return Trajectories(frame=table[:, 0], id=table[:, 1], position=position_of(table[:, 2]))


def annotated_feet(folder: Path) -> Iterator[tuple[int, int, float, float, int]]:
    """
    Yield the middles of the lower edges of the boxes that end in the image.

    Whole pixels are taken at their middle.

    Yields
    ------
    int, int, float, float, int
        Frame, camera's index, column and row, px, and the position's number.

    """
    width, height = IMAGE_SIZE
    for frame, person in _annotated(folder):
        for view in person['views']:
            column, row = (view['xmin'] + view['xmax'] + 1) / 2, view['ymax'] + 0.5
            if view['xmax'] > 0 and 0 <= column < width and row < height - 0.5:
                yield frame, view['viewNum'], column, row, person['positionID']


def _annotated(folder: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield frame and annotation of each person; the fifth video image is the second frame."""
    with tarfile.open(folder / 'annotations_positions_train.tar.gz') as archive:
        for member in archive.getmembers():
            file = archive.extractfile(member) if member.name.endswith('.json') else None
            for person in json.load(file) if file is not None else []:
                yield int(Path(member.name).stem) // 5, person


def position_of(position_id: NDArray[np.int64]) -> Floats:
    """Return the (n, 2) ground positions, m, of positions' numbers."""
    return np.column_stack(
        [-3.0 + 0.025 * (position_id % 480), -9.0 + 0.025 * (position_id // 480)]
    )
