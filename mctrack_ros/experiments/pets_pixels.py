"""PETS 2009 S2.L1, view 1, from pixels: one camera through the whole pipeline."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from defusedxml.ElementTree import parse
from numpy.typing import NDArray

from mctrack_ros.ground import ProjectiveMapping

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

CALIBRATED_SIZE = (768, 576)
FRAME_RATE = 7.0


class TsaiCamera:
    """
    A camera calibrated after Tsai (1987): pose, pinhole, one radial distortion term.

    Parameters
    ----------
    path : Path
        XML file of the PETS calibration; lengths in mm, angles in rad.
    size : (int, int)
        Width and height of the pictures to be mapped, px; the calibrated size is scaled to it.

    """

    def __init__(self, path: Path, size: tuple[int, int]) -> None:
        geometry, intrinsic, extrinsic = (
            _attributes(path, name) for name in ('Geometry', 'Intrinsic', 'Extrinsic')
        )
        scale = size[0] / CALIBRATED_SIZE[0]
        self._size = size
        self._radial = intrinsic['kappa1']
        focal = intrinsic['focal']
        per_mm = np.array([intrinsic['sx'] / geometry['dpx'], 1 / geometry['dpy']]) * scale
        centre = np.array([intrinsic['cx'], intrinsic['cy']]) * scale
        self._centre, self._per_mm = centre, per_mm
        intrinsics = np.array(
            [[focal * per_mm[0], 0, centre[0]], [0, focal * per_mm[1], centre[1]], [0, 0, 1]]
        )
        rotation = _rotation(extrinsic['rx'], extrinsic['ry'], extrinsic['rz'])
        translation = np.array([extrinsic[name] for name in ('tx', 'ty', 'tz')]) / 1000
        self.mapping = ProjectiveMapping(
            intrinsics @ np.column_stack([rotation, translation]), size
        )

    def undistortion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the maps with which `cv2.remap` makes the picture that of a pinhole."""
        width, height = self._size
        column, row = np.meshgrid(np.arange(width), np.arange(height))
        ideal = (np.dstack([column, row]) - self._centre) / self._per_mm
        distorted = ideal.copy()
        for _ in range(10):
            square = (distorted**2).sum(axis=2, keepdims=True)
            distorted = ideal / (1 + self._radial * square)
        pixel = distorted * self._per_mm + self._centre
        return pixel[..., 0].astype(np.float32), pixel[..., 1].astype(np.float32)


def pictures(folder: Path, camera_maps: tuple[Any, Any]) -> Iterator[tuple[int, Image]]:
    """Yield the frame number, as the truth counts (from 1), and the undistorted picture."""
    video = cv2.VideoCapture(str(folder / 'video' / 'vtest_480x360.avi'))
    frame = 0
    while True:
        there, image = video.read()
        if not there:
            break
        frame += 1
        yield frame, cv2.remap(image, *camera_maps, cv2.INTER_LINEAR)  # type: ignore[misc]


def _rotation(around_x: float, around_y: float, around_z: float) -> Floats:
    """Return the rotation of Tsai's angles, rad: about x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = (
        function(np.array([around_x, around_y, around_z])) for function in (np.cos, np.sin)
    )
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    rotation: Floats = about_z @ about_y @ about_x
    return rotation


def _attributes(path: Path, name: str) -> dict[str, float]:
    root = parse(str(path)).getroot()
    element = None if root is None else root.find(name)
    if element is None:
        raise ValueError(f'{path}: <{name}> is not there')
    return {key: float(value) for key, value in element.attrib.items()}
