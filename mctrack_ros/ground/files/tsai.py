"""Cameras calibrated after Tsai (1987), as in the PETS data: XML with mm and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mctrack_ros.ground.camera.lens import (
    LARGEST_RESIDUAL_PX,
    farthest_radius,
    fit_lens,
    image_samples,
    seen_directions,
)
from mctrack_ros.ground.camera.stored import Pose, StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import TSAI, sorted_keys
from mctrack_ros.ground.xml_files import read_xml, tag, write_lines

Floats = NDArray[np.float64]
WRITTEN_PIXEL_MM = 0.01
"""Size of a sensor element in files that are written: only its product with others matters."""
MM_PER_M = 1000.0
RADII = 400
REWEIGHTED = 3
STEEPEST = 1e-3
"""Slope of the undistorted place by the shown one from which a lens counts as folded."""
UNFOLDED = 0.97
"""How near to its fold a lens is followed, as a share of the radius there."""
MOST_FOLDED = 0.05
"""Share of an image that may lie beyond."""
_NEEDED = {
    'Geometry': ('width', 'height', 'dpx', 'dpy'),
    'Intrinsic': ('focal', 'kappa1', 'cx', 'cy', 'sx'),
    'Extrinsic': ('tx', 'ty', 'tz', 'rx', 'ry', 'rz'),
}


@dataclass(frozen=True, eq=False, slots=True)
class TsaiCalibration:
    """
    What a Tsai file says.

    Attributes
    ----------
    image_size : (int, int)
        Width and height of the images, px.
    focal_mm, kappa1 : float
        Focal length, mm, and radial term, 1/mm²: undistorted = distorted (1 + kappa1 r²).
    per_mm : (2,) array
        Pixels of a millimetre on the sensor, across and down.
    centre : (2,) array
        Principal point, px.
    rotation : (3, 3) array
        From world to camera axes.
    translation : (3,) array
        The world's origin in camera axes, m.

    """

    image_size: tuple[int, int]
    focal_mm: float
    kappa1: float
    per_mm: Floats
    centre: Floats
    rotation: Floats
    translation: Floats

    def camera(self) -> StoredCamera:
        """
        Return the camera with OpenCV's lens, fitted to Tsai's over the image.

        A negative `kappa1` folds the image over at 1 / sqrt(-3 kappa1) from its centre: what is
        farther, or nearer to that than 3 %, has no direction to follow.

        Raises
        ------
        CalibrationError
            If no such lens follows it, or more than 5 % of the image is so.

        """
        intrinsics = np.concatenate([self.focal_mm * self.per_mm, self.centre])
        bend = self.kappa1 * self.focal_mm**2
        widest = UNFOLDED / np.sqrt(-3 * bend) if bend < 0 else np.inf
        away = (image_samples(self.image_size) - self.centre) / intrinsics[:2]
        folded = float((np.linalg.norm(away, axis=1) > widest).mean())
        if folded > MOST_FOLDED:
            raise CalibrationError(
                f'its kappa1 of {self.kappa1:g} folds {folded:.0%} of the image over, expected '
                f'at most {MOST_FOLDED:.0%}'
            )
        farthest = min(widest, farthest_radius(intrinsics, self.image_size))
        shown = np.linspace(0, farthest, RADII)[1:]
        radius = shown * (1 + bend * shown**2)
        intrinsics, distortion, residual = fit_lens(intrinsics, radius, shown)
        pose = Pose(self.rotation, self.translation)
        return StoredCamera(intrinsics, distortion, pose, self.image_size, residual)


def read_tsai(path: str | Path) -> TsaiCalibration:
    """
    Read a Tsai XML file; entities are refused.

    Raises
    ------
    CalibrationError
        If the file cannot be read, or an element or number is missing or wrong.

    """
    root = read_xml(path, CalibrationError)
    values: dict[str, float] = {}
    for name, attributes in _NEEDED.items():
        element = root.find(name)
        if element is None:
            raise CalibrationError(f'{path}:{root.sourceline}: <{root.tag}> has no <{name}>')
        sorted_keys(dict(element.items()), f'{path}:{element.sourceline}: <{name}>', TSAI)
        for key in attributes:
            values[key] = _number(element.get(key), f'{path}:{element.sourceline}: <{name}> {key}')
    if min(values[key] for key in ('width', 'height', 'dpx', 'dpy', 'focal', 'sx')) <= 0:
        raise CalibrationError(
            f'{path}: width, height, dpx, dpy, focal and sx are expected above 0'
        )
    return TsaiCalibration(
        (round(values['width']), round(values['height'])),
        values['focal'],
        values['kappa1'],
        np.array([values['sx'] / values['dpx'], 1 / values['dpy']]),
        np.array([values['cx'], values['cy']]),
        Rotation.from_euler('xyz', [values['rx'], values['ry'], values['rz']]).as_matrix(),
        np.array([values['tx'], values['ty'], values['tz']]) / MM_PER_M,
    )


def write_tsai(
    camera: StoredCamera, image_size: tuple[int, int], name: str, path: str | Path
) -> float:
    """
    Write a camera as a Tsai XML file, its lens by the one radial term that fits best.

    Returns
    -------
    float
        How far at most that term misses the lens over the image, px.

    Raises
    ------
    CalibrationError
        If that is more than a pixel, or the camera has no pose.

    """
    if camera.pose is None:
        raise CalibrationError('the camera has no pose: a Tsai file needs one')
    aspect = float(camera.intrinsics[0] / camera.intrinsics[1])
    focal_mm, kappa1, missed = _tsai_lens(camera, image_size)
    if not missed <= LARGEST_RESIDUAL_PX:
        raise CalibrationError(
            f"Tsai's one radial term misses the lens by up to {missed:.2g} px, expected at most "
            f'{LARGEST_RESIDUAL_PX:g} px'
        )
    rx, ry, rz = Rotation.from_matrix(camera.pose.rotation).as_euler('xyz').tolist()
    tx, ty, tz = (camera.pose.translation * MM_PER_M).tolist()
    width, height = (str(side) for side in image_size)
    size_mm, (cx, cy) = WRITTEN_PIXEL_MM, camera.intrinsics[2:].tolist()
    lines = [
        tag('Camera', end='', name=name),
        '  ' + tag('Geometry', width=width, height=height, ncx=width, nfx=width,
                   dx=size_mm, dy=size_mm, dpx=size_mm, dpy=size_mm),
        '  ' + tag('Intrinsic', focal=focal_mm, kappa1=kappa1, cx=cx, cy=cy, sx=aspect),
        '  ' + tag('Extrinsic', tx=tx, ty=ty, tz=tz, rx=rx, ry=ry, rz=rz),
        '</Camera>',
    ]  # fmt: skip
    write_lines(path, lines)
    return missed


def _tsai_lens(camera: StoredCamera, image_size: tuple[int, int]) -> tuple[float, float, float]:
    """Return focal length (mm), kappa1, and how far at most they miss the lens, px."""
    across, down = camera.intrinsics[:2]
    focal_mm = float(down) * WRITTEN_PIXEL_MM
    if not camera.distortion.any():
        return focal_mm, 0.0, 0.0
    per_mm = np.array([across / down, 1.0]) / WRITTEN_PIXEL_MM
    direction, pixel = seen_directions(camera.intrinsics, camera.distortion, image_size)
    sensor, goal = (pixel - camera.intrinsics[2:]) / per_mm, direction * focal_mm
    square = (sensor**2).sum(axis=1, keepdims=True)
    terms, weight = np.stack([sensor, sensor * square], axis=-1), np.ones_like(square)
    for _ in range(REWEIGHTED):
        design = (terms * weight[..., None]).reshape(-1, 2)
        share, bend = np.linalg.lstsq(design, (goal * weight).ravel(), rcond=None)[0].tolist()
        # a miss on the sensor is one of the undistorted place by the slope of the one by the other
        weight = 1 / np.maximum(share + 3 * bend * square, STEEPEST)
    missed = np.linalg.norm((goal - terms @ [share, bend]) * weight * per_mm, axis=1).max()
    return focal_mm / share, bend / share, float(missed)


def _number(text: str | None, where: str) -> float:
    if text is None:
        raise CalibrationError(f'{where} is missing')
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise CalibrationError(f'{where} is {text!r}, expected a finite number')
    return value
