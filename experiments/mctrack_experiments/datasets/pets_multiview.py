"""PETS 2009 S2.L1: stored detections of six views."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.stored import Floats, StoredScene, stamp_of
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.boxes import BodyModel, boxes_to_detections

RATE = 7.0
VIEWS = (1, 3, 5, 6, 7, 8)
"""View 4 is badly calibrated or not in step."""

LEAST_SCORE = 0.9
IMAGE_SIZES = {
    1: (768, 576),
    3: (768, 576),
    5: (720, 576),
    6: (720, 576),
    7: (720, 576),
    8: (720, 576),
}


class PetsView:
    """
    A view's calibration: pose, pinhole and distortion.

    Parameters
    ----------
    folder : Path
        Folder of the data set.
    view : int
        Number of the view.

    """

    def __init__(self, folder: Path, view: int) -> None:
        stored = json.loads((folder / 'calibration' / 'mot3d_calibration.json').read_text())
        camera = stored[f'View_{view:03d}']
        self._intrinsics = np.array(camera['K'], np.float64)
        self._distortion = np.array(camera['dist'], np.float64)
        metres = np.array(camera['t'], np.float64) / 1000
        pose = np.column_stack([np.array(camera['R'], np.float64), metres])
        self.mapping = ProjectiveMapping(self._intrinsics @ pose, IMAGE_SIZES[view])

    def undistorted(self, pixel: Floats) -> Floats:
        """Return (n, 2) pixels as a pinhole would see them."""
        if len(pixel) == 0:
            return pixel
        points = cv2.undistortPoints(
            pixel[:, None], self._intrinsics, self._distortion, P=self._intrinsics
        )
        return np.asarray(points[:, 0], np.float64)


def load_pets_multiview(folder: Path, body: BodyModel) -> StoredScene:
    """
    Load the detections of six views, and the truth of view 1.

    Parameters
    ----------
    folder : Path
        Folder of the data set.
    body : BodyModel
        What is assumed about people and boxes.

    """
    detections = {}
    for view in VIEWS:
        name = f'keypointsrcnn_resnet50_fpn_View_{view:03d}_finetuned_2.json.gz'
        with gzip.open(folder / 'detections_multiview' / name, 'rt') as file:
            stored = json.load(file)
        camera = PetsView(folder, view)
        detections[f'view{view}'] = [
            _image(camera, boxes, scores, index, body)
            for index, (boxes, scores) in enumerate(zip(stored['bboxes'], stored['scores']))
        ]
    count = len(detections['view1'])
    return StoredScene(np.arange(1, count + 1), RATE, detections, read_truth(folder))


def read_truth(folder: Path) -> Trajectories:
    """Read MOTChallenge's labels; those of confidence 0 are to be ignored."""
    table = np.loadtxt(folder / 'gt' / '3DMOT2015_PETS09-S2L1_gt.txt', delimiter=',')
    frame, person = table[:, :2].astype(np.int64).T
    return Trajectories(frame=frame, id=person, position=table[:, 7:9], ignore=table[:, 6] == 0)


def annotated(folder: Path, position: Floats, truth: Trajectories) -> NDArray[np.bool_]:
    """
    Tell which ground positions, (n, 2) m, the truth would cover.

    It covers what view 1 shows, and nobody is annotated outside the rectangle that it spans.
    """
    mapping = PetsView(folder, 1).mapping
    pixel = mapping.image_from_ground(position)
    inside: NDArray[np.bool_] = np.all((pixel >= 0) & (pixel < mapping.image_size), axis=1)
    low, high = truth.position.min(axis=0), truth.position.max(axis=0)
    inside &= np.all((position >= low) & (position <= high), axis=1)
    return inside


def _image(camera: PetsView, boxes: Any, scores: Any, index: int, body: BodyModel) -> Detections:
    corners = np.asarray(boxes, np.float64).reshape(-1, 4)
    score = np.asarray(scores, np.float64).reshape(-1)
    corners, score = corners[score > LEAST_SCORE], score[score > LEAST_SCORE]
    centre = (corners[:, 0] + corners[:, 2]) / 2
    top = camera.undistorted(np.column_stack([centre, corners[:, 1]]))
    bottom = camera.undistorted(np.column_stack([centre, corners[:, 3]]))
    width = corners[:, 2] - corners[:, 0]
    middle = (top[:, 0] + bottom[:, 0]) / 2
    straight = np.column_stack([middle - width / 2, top[:, 1], width, bottom[:, 1] - top[:, 1]])
    return boxes_to_detections(straight, score, camera.mapping, stamp_of(index, RATE), body)
