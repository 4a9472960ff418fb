"""EPFL's laboratory with six people: four cameras, stored foot detections."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.experiments.datasets.stored import StoredScene, feet_to_detections, stamp_of
from mctrack_ros.ground import ProjectiveMapping

RATE = 25.0
CAMERAS = ('6p-c0', '6p-c1', '6p-c2', '6p-c3')
IMAGE_SIZE = (360, 288)
TOP_VIEW_PX_PER_M = 50.0


def load_lab6p(folder: Path, kind: str, foot_sigma_px: float) -> StoredScene:
    """
    Load the foot detections of Social-Pose and EPFL's truth, which is given once a second.

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
    detections = {}
    for camera in CAMERAS:
        mapping = _mapping(folder / 'Calibration' / f'{camera}.mat')
        stored = loadmat(folder / 'Ground_Position_Detections' / f'{camera}.mat')
        detections[camera] = [
            feet_to_detections(_points(cell), mapping, stamp_of(index, RATE), foot_sigma_px)
            for index, cell in enumerate(stored[f'gp_uv_{kind}'][0])
        ]
    count = len(detections[CAMERAS[0]])
    truth = read_truth(folder / 'gt_epfl' / 'ground_table.txt')
    return StoredScene(np.arange(1, count + 1), RATE, detections, truth)


def read_truth(path: Path) -> Trajectories:
    """Read EPFL's table; the last line of a frame holds all people, the k-th is person k."""
    people: dict[int, list[tuple[float, float]]] = {}
    for line in path.read_text().splitlines():
        frame, _, rest = line.partition(' ')
        pairs = re.findall(r'\((\d+), (\d+)\)', rest)
        people[int(frame)] = [
            ((int(x) + 0.5) / TOP_VIEW_PX_PER_M, (int(y) + 0.5) / TOP_VIEW_PX_PER_M)
            for x, y in pairs
        ]
    rows = [
        (frame, person, *place)
        for frame, places in people.items()
        for person, place in enumerate(places, 1)
    ]
    table = np.array(rows)
    frame, person = table[:, :2].astype(np.int64).T
    return Trajectories(frame=frame, id=person, position=table[:, 2:])


def _mapping(path: Path) -> ProjectiveMapping:
    stored = loadmat(path)
    scale = np.diag([1 / float(stored['Scale'][0, 0]), 1 / float(stored['Scale'][0, 0]), 1.0])
    return ProjectiveMapping.from_homography(np.linalg.inv(scale @ stored['H']), IMAGE_SIZE)


def _points(cell: Any) -> NDArray[np.float64]:
    return np.asarray(cell, np.float64).reshape(-1, 2)
