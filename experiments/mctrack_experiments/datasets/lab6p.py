"""EPFL's laboratory with six people: four cameras, stored foot detections."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from mctrack_experiments.datasets.social_pose import load_feet
from mctrack_experiments.datasets.stored import StoredScene
from mctrack_ros.evaluation import Trajectories

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
        Which detections, as in `load_feet`.
    foot_sigma_px : float
        Standard deviation of a foot point, px.

    """
    detections = {
        camera: load_feet(folder, camera, kind, IMAGE_SIZE, RATE, foot_sigma_px)
        for camera in CAMERAS
    }
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
