"""A camera from named values: files of OpenCV's, ROS's, and of scripts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.camera.stored import StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import plain
from mctrack_ros.ground.files.keyed.lens_models import lens_model, lens_of
from mctrack_ros.ground.files.keyed.pose import stated_pose
from mctrack_ros.ground.files.keyed.stated import Stated, whole

Floats = NDArray[np.float64]
LARGEST_SKEW_PX = 1.0
"""A skew that moves the pixels of an image by less (root mean square) is left out."""
_CLOSE = 1e-9  # rounding of what is written as 0 or 1


def camera_of(
    values: Mapping[Any, Any], where: str | Path, image_size: tuple[int, int] | None = None
) -> StoredCamera:
    """
    Return the camera that a file states, for raw (not rectified) images.

    Where it states binning or a region of interest, the images are those, as `image_geometry`
    reads it.

    Parameters
    ----------
    values : mapping
        What the file holds: numbers, texts, lists, or mappings with `data`.
    where : str or Path
        What it is from, to name.
    image_size : (int, int), optional
        Width and height of the images, px; needed if the file does not state it.

    Raises
    ------
    CalibrationError
        If the matrix or the lens is missing, a value is none, or something is stated that is not
        known; names it.

    """
    stated = Stated(values, where)
    if 'matrix' not in stated:
        raise stated.error('no camera_matrix')
    matrix = stated.numbers('matrix', 9).reshape(3, 3)
    if 'lens' not in stated or not ('model' in stated or len(stated.numbers('lens'))):
        raise stated.error(
            'a camera matrix, but no distortion_coefficients: write them, zeros if the images '
            'are without distortion'
        )
    if not matrix.any():
        raise stated.error('the camera is not calibrated')
    intrinsics, skew = _intrinsics(matrix, stated)
    window = _window(stated)
    if window is not None:
        intrinsics[2:] -= window.left, window.top
        intrinsics /= window.across, window.down, window.across, window.down
        skew, image_size = skew / window.across, window.image_size
    if image_size is None:
        raise stated.error('it does not say how large the images are')
    model = _model(stated)
    try:
        notes = (
            *_skew_notes(skew, intrinsics, image_size),
            *_centre_notes(intrinsics, image_size),
        )
        lens = lens_of(model, intrinsics, stated.numbers('lens'), image_size)
    except CalibrationError as error:
        raise stated.error(str(error)) from error
    size = None if window is None else window.image_size
    return StoredCamera(lens[0], lens[1], stated_pose(stated), size, lens[2], notes)


def size_of(values: Mapping[Any, Any], where: str | Path) -> tuple[int, int] | None:
    """Return the width and height, px, of the images that a camera sends, if it is stated."""
    window = _window(Stated(values, where))
    return None if window is None else window.image_size


@dataclass(frozen=True, slots=True)
class _Window:
    """What of the sensor's images is sent: corner, width and height, px, and binning."""

    left: int
    top: int
    width: int
    height: int
    across: int
    down: int

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height of the images that are sent, px."""
        return self.width // self.across, self.height // self.down


def _window(stated: Stated) -> _Window | None:
    """Return what is sent of the sensor's images, if the file says how large they are."""
    size = _sensor_size(stated)
    region = stated.value('region') or {}
    if not isinstance(region, Mapping):
        raise stated.error(f'{stated.key("region")} is {region!r}, expected a mapping')
    left, top, width, height = (
        whole(region.get(key), f'{stated.where}: {stated.key("region")} {key}')
        for key in ('x_offset', 'y_offset', 'width', 'height')
    )
    across, down = (max(stated.whole(each), 1) for each in ('binning_x', 'binning_y'))
    if size is None:
        if any((left, top, width, height, across > 1, down > 1)):
            raise stated.error('a region or binning, but no image_width and image_height')
        return None
    if min(size) <= 0:
        raise stated.error('the camera is not calibrated')
    if left + width > size[0] or top + height > size[1]:
        raise stated.error(
            f'{stated.key("region")} reaches out of the images of {size[0]} x {size[1]} px'
        )
    window = _Window(left, top, width or size[0], height or size[1], across, down)
    if min(window.image_size) <= 0:
        raise stated.error(f'binning by {across} x {down} leaves no pixel')
    return window


def _sensor_size(stated: Stated) -> tuple[int, int] | None:
    """Return the width and height of the sensor's images, px, if they are stated."""
    sizes = set()
    if 'width' in stated or 'height' in stated:
        if not ('width' in stated and 'height' in stated):
            alone = stated.key('width') or stated.key('height')
            raise stated.error(f'{alone} alone: expected image_width and image_height')
        sizes.add((stated.whole('width'), stated.whole('height')))
    if 'size' in stated:
        width, height = stated.numbers('size', 2).tolist()
        name = f'{stated.where}: {stated.key("size")}'
        sizes.add((whole(width, name), whole(height, name)))
    if len(sizes) > 1:
        raise stated.error(f'two sizes of images, {sorted(sizes)}: keep one')
    return sizes.pop() if sizes else None


def _model(stated: Stated) -> str:
    """Return the lens model, one of `lens_models.TERMS`: by its name, or else by its terms."""
    terms, fisheye = stated.numbers('lens'), _fisheye(stated)
    try:
        found = {lens_model(value) for _, value in stated.each('model')} - {''}
    except CalibrationError as error:
        raise stated.error(str(error)) from error
    if fisheye:
        found.add('equidistant')
    if len(found) > 1 or (found == {'equidistant'} and fisheye is False):
        raise stated.error(f'two lens models, {stated.key("model")} and {stated.key("fisheye")}')
    if found == {'none'} and terms.any():
        raise stated.error(f'no lens model, but {len(terms)} terms of one')
    if found == {'equidistant'} and not len(terms):
        raise stated.error('a fisheye, but no lens terms')
    if found:
        return found.pop()
    if fisheye is None and len(terms) == 4 and terms.any():
        raise stated.error(
            'four lens terms can be of a fisheye or not: say which, as distortion_model: '
            'equidistant or distortion_model: plumb_bob'
        )
    return 'plumb_bob' if len(np.trim_zeros(terms, 'b')) <= 5 else 'rational_polynomial'


def _fisheye(stated: Stated) -> bool | None:
    """Return whether the file says that the lens is a fisheye; None if it says nothing."""
    if 'fisheye' not in stated:
        return None
    said = plain(stated.value('fisheye'))
    if said not in ('0', '1', 'true', 'false'):
        raise stated.error(f'{stated.key("fisheye")} is {said!r}, expected 0 or 1')
    return said in ('1', 'true')


def _intrinsics(matrix: Floats, stated: Stated) -> tuple[Floats, float]:
    """Return the focal lengths and principal point, (4,) px, and the skew of a camera matrix."""
    skew = float(matrix[0, 1])
    if 'skew' in stated:
        named = float(stated.numbers('skew', 1)[0])
        if skew and not math.isclose(skew, named):
            raise stated.error(f'two skews, {skew:g} and {named:g}: keep one')
        skew = named
    rest = matrix[[1, 2, 2, 2], [0, 0, 1, 2]] - (0, 0, 0, 1)
    if np.abs(rest).max() > _CLOSE or min(matrix[0, 0], matrix[1, 1]) <= 0:
        raise stated.error(
            f'the camera matrix is {matrix.tolist()}, expected [[fx, 0, cx], [0, fy, cy], '
            '[0, 0, 1]]'
        )
    return matrix[[0, 1, 0, 1], [0, 1, 2, 2]], skew


def _skew_notes(skew: float, intrinsics: Floats, image_size: tuple[int, int]) -> tuple[str, ...]:
    """Return what a skew does that is left out; refuse one that does much."""
    if not skew:
        return ()
    rows = np.linspace(0, image_size[1], 101)
    moved = np.abs(skew * (rows - intrinsics[3]) / intrinsics[1])
    usual, most = float(np.sqrt((moved**2).mean())), float(moved.max())
    effect = f'its skew of {skew:.3g} moves pixels by {usual:.2g} px (RMS; at most {most:.2g} px)'
    if usual >= LARGEST_SKEW_PX:
        raise CalibrationError(
            f'{effect}, expected below {LARGEST_SKEW_PX:g} px: calibrate with the skew fixed at 0'
        )
    return (f'{effect}: it is left out',)


def _centre_notes(intrinsics: Floats, image_size: tuple[int, int]) -> tuple[str, ...]:
    """Return that the principal point lies outside the images, if it does."""
    (x, y), (width, height) = intrinsics[2:].tolist(), image_size
    if 0 < x < width and 0 < y < height:
        return ()
    return (
        f'its principal point ({x:.0f}, {y:.0f}) lies outside its images of {width} x {height} '
        'px: is the matrix that of another size?',
    )
