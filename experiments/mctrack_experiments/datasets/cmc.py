"""Curtin's room with four corner cameras: boxes of Faster R-CNN."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from mctrack_experiments.datasets.stored import StoredScene, cut_to, stamp_of
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.boxes import BodyModel, boxes_to_detections

RATE = 4.0
FRAMES = 261
IMAGE_SIZE = (1920, 1024)
AREA = ((2.03, 6.3), (0.0, 3.41))
"""Where people are tracked: x and y, m."""

TRUTH_FILES = {1: 'GT_J_1_1_WORLD_CENTROID.txt', 2: 'GT_J_5_2_WORLD_CENTROID.txt'}


def load_cmc(folder: Path, sequence: int, body: BodyModel) -> StoredScene:
    """
    Load CMC1 (3 people) or CMC2 (10 people).

    Parameters
    ----------
    folder : Path
        Folder of the data set.
    sequence : int
        1 or 2.
    body : BodyModel
        What is assumed about people and boxes.

    """
    detections = {}
    for number in range(1, 5):
        mapping = ProjectiveMapping(_matrix(folder / f'cam{number}_cam_mat.mat'), IMAGE_SIZE)
        table = np.loadtxt(folder / f'DET_CMC{sequence}_Cam{number}.txt')
        detections[f'cam{number}'] = [
            _image(table[table[:, 0] == index + 1, 2:6], mapping, index, body)
            for index in range(FRAMES)
        ]
    table = np.loadtxt(folder / TRUTH_FILES[sequence])
    frame, person = table[:, :2].astype(np.int64).T
    truth = Trajectories(frame=frame, id=person, position=table[:, 7:9])
    return StoredScene(np.arange(1, FRAMES + 1), RATE, detections, truth)


def _image(
    boxes: np.ndarray, mapping: ProjectiveMapping, index: int, body: BodyModel
) -> Detections:
    stamp_ns = stamp_of(index, RATE)
    return cut_to(boxes_to_detections(boxes, np.ones(len(boxes)), mapping, stamp_ns, body), AREA)


def _matrix(path: Path) -> np.ndarray:
    with h5py.File(path) as file:
        return np.asarray(file[f'{path.stem}'], np.float64).T
