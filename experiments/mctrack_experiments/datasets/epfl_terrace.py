"""EPFL's terrace: four cameras, two of them as videos, and truth of two kinds."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mctrack_experiments.datasets.stored import Floats, inside
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground.xml_files import tag, write_lines

FOLDER = 'epfl_terrace4'
VIDEO_FOLDER = 'epfl_terrace_video'
CAMERAS = ('c0', 'c1', 'c2', 'c3')
SIZE = (360, 288)
PERIOD_NS = 40_000_000
"""Of the original, ns: an image's number is that of its frame there."""
AREA = ((-0.5, 7.0), (-1.5, 9.5))
"""What is annotated: x and y, m."""
_METRES_FROM_TOP_VIEW = np.array([[21.556, 0.159, -400.7], [0.574, -21.397, 8726.6]]) / 1000
CUT_OFF_PX = 284
"""A box that ends so low is cut off by the lower border: its feet are not in the image."""
_CALIBRATED_SCALE = 2
"""The cameras were calibrated on images so many times as large."""
_CALIBRATED_PIXEL_MM = 0.023


def top_view_from_image(data: Path, camera: str) -> Floats:
    """Return a camera's homography, (3, 3), from its images to pixels of a common top view."""
    views = json.loads((data / VIDEO_FOLDER / 'gnn_cca_metainfo.json').read_text())['terrace']
    return np.array(views['homography'][CAMERAS.index(camera)], np.float64)


def metres_from_top_view(pixel: Floats) -> Floats:
    """Return pixels of the top view, (n, 2), in the metres of the Tsai calibration."""
    metres: Floats = pixel @ _METRES_FROM_TOP_VIEW[:, :2].T + _METRES_FROM_TOP_VIEW[:, 2]
    return metres


def write_calibration(data: Path, camera: str, path: Path) -> None:
    """Write a camera's calibration, for images of `SIZE`, as a Tsai file (mm)."""
    stored = json.loads((data / VIDEO_FOLDER / 'terrace_tsai_transcribed.json').read_text())
    tx, ty, tz, rx, ry, rz = stored[camera]['extrinsic']
    focal, kappa1, cx, cy = stored[camera]['intrinsic']
    width, height = (str(side) for side in SIZE)
    pixel_mm = _CALIBRATED_PIXEL_MM * _CALIBRATED_SCALE
    cx, cy = cx / _CALIBRATED_SCALE, cy / _CALIBRATED_SCALE
    lines = [
        tag('Camera', end='', name=camera),
        '  ' + tag('Geometry', width=width, height=height, dpx=pixel_mm, dpy=pixel_mm),
        '  ' + tag('Intrinsic', focal=focal, kappa1=kappa1, cx=cx, cy=cy, sx=1.0),
        '  ' + tag('Extrinsic', tx=tx, ty=ty, tz=tz, rx=rx, ry=ry, rz=rz),
        '</Camera>',
    ]
    write_lines(path, lines)


def image_files(data: Path, camera: str) -> dict[int, Path]:
    """Return the images of a camera by the number of their frame, ascending."""
    files = sorted((data / FOLDER / camera).glob('*.jpg'))
    return {int(file.stem): file for file in files}


def read_positions(data: Path) -> Trajectories:
    """Read where everybody in the area was; ids only tell the rows apart."""
    table = np.loadtxt(data / FOLDER / 'positions.csv', delimiter=',', skiprows=1)
    frame = table[:, 0].astype(np.int64)
    return Trajectories(frame=frame, id=np.arange(len(frame)), position=table[:, 1:])


def read_identities(data: Path, cameras: Sequence[str] = CAMERAS) -> Trajectories:
    """
    Read who was where: the mean of the feet that cameras see, in the area.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    cameras : sequence of str
        Whose boxes are used.

    """
    seen = np.concatenate([_feet(data, camera) for camera in cameras])
    keys, index, count = np.unique(
        seen[:, :2].astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    position = np.zeros((len(keys), 2))
    np.add.at(position, index.reshape(-1), seen[:, 2:])
    position /= count[:, None]
    truth = Trajectories(frame=keys[:, 0], id=keys[:, 1], position=position)
    return truth.select(inside(truth.position, AREA))


def _feet(data: Path, camera: str) -> Floats:
    """Return frame, person, x and y (m), (n, 4), of the boxes whose feet a camera shows."""
    boxes = np.loadtxt(data / FOLDER / f'boxes_{camera}.txt.gz', usecols=range(7))
    bottom, lost = boxes[:, 4], boxes[:, 6]
    boxes = boxes[(lost != 1) & (bottom < CUT_OFF_PX)]
    person, left, _, right, bottom, frame, _ = boxes.T
    feet = np.stack([(left + right) / 2, bottom, np.ones(len(boxes))])
    x, y, scale = top_view_from_image(data, camera) @ feet
    position = metres_from_top_view(np.column_stack([x, y]) / scale[:, None])
    # the frames of boxes are counted from 0, those of images from 1
    return np.column_stack([frame + 1, person, position])
