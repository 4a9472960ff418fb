"""Any calibration file: read by what it holds, written in the format that is asked for."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.ground.camera.lens import LARGEST_RESIDUAL_PX, STRAIGHT_PX, bend_px
from mctrack_ros.ground.camera.pinhole import CameraMapping
from mctrack_ros.ground.camera.stored import Pose, StoredCamera, stored_camera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.camera_info import read_yaml, write_camera_info
from mctrack_ros.ground.files.foreign import how_to_write
from mctrack_ros.ground.files.kalibr import kalibr_cameras, read_kalibr
from mctrack_ros.ground.files.keyed.camera import camera_of, size_of
from mctrack_ros.ground.files.keyed.keys import states_camera
from mctrack_ros.ground.files.keyed.pose import pose_in
from mctrack_ros.ground.files.opencv import read_opencv, write_opencv
from mctrack_ros.ground.files.ost import is_ost, read_ost
from mctrack_ros.ground.files.projection import holds_projection, read_projection, write_projection
from mctrack_ros.ground.files.several_cameras import ANY, Choice
from mctrack_ros.ground.files.tsai import read_tsai, write_tsai
from mctrack_ros.ground.grid.file import read_grid, write_grid
from mctrack_ros.ground.grid.methods import mapping_from_grid
from mctrack_ros.ground.grid.sampling import grid_miss_px, sampled_grid
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.plausible import check_plausible
from mctrack_ros.ground.xml_files import read_xml
from mctrack_ros.input_size import SETTINGS, check_size

METRES = {'m': 1.0, 'cm': 0.01, 'mm': 0.001}
"""Units of length that calibration files may be in."""
_ROOTS = {'workstation': 'grid', 'opencv_storage': 'opencv', 'Camera': 'tsai'}


def file_format(path: str | Path) -> str:
    """
    Return what a calibration file holds, one of `FORMATS`; matrices are ``projection``.

    Formats that are only read are ``kalibr`` and ``ost``, the old text of `camera_calibration`.

    Raises
    ------
    CalibrationError
        If it is nothing that is known.

    """
    return _content(path)[0]


def holds_camera(path: str | Path) -> bool:
    """Tell whether a calibration file holds a camera, as `read_camera` reads it."""
    return file_format(path) not in ('grid', 'projection')


def read_calibration(
    path: str | Path,
    image_size: tuple[int, int],
    extrinsics: str | Path = '',
    unit: str = 'm',
    choice: Choice = ANY,
) -> GroundMapping:
    """
    Read a calibration of any format.

    Parameters
    ----------
    path : str or Path
        Transformation grid (mapped by a fitted camera), Tsai XML, OpenCV XML or YAML, the YAML or
        the printed message of a ROS camera info, Kalibr's chain, or a YAML with one matrix.
    image_size : (int, int)
        Width and height of the camera's images, px.
    extrinsics : str or Path
        File with the camera's pose, if it is another; replaces the one in `path`.
    unit : str
        Of lengths in the files, one of `METRES`; grids are in metres, Tsai's in millimetres.
    choice : Choice
        Which camera, where a file holds several.

    Raises
    ------
    CalibrationError
        If a file cannot be used, states what is not known, is for images of another size, or
        cannot be true; names it.

    """
    metres = _metres(unit)
    kind = file_format(path)
    if kind in ('grid', 'tsai') and unit != 'm':
        raise CalibrationError(f'{path}: its lengths have a unit of their own, not {unit}')
    if kind in ('grid', 'projection'):
        if extrinsics:
            raise CalibrationError(f'{path}: needs no extrinsics beside it')
        _check_single(path, choice)
    if kind == 'projection':
        mapping: GroundMapping = read_projection(path, image_size, metres)
        return _checked(path, lambda: mapping)
    if kind == 'grid':
        grid = read_grid(path)
        return _checked(path, lambda: mapping_from_grid(grid, image_size))
    camera = read_camera(path, image_size, extrinsics, choice)
    return camera_mapping(camera, path, image_size, unit)


def stated_size(path: str | Path, choice: Choice = ANY) -> tuple[int, int] | None:
    """
    Return the size of the images, px, that a calibration file states; None: it does not.

    Raises
    ------
    CalibrationError
        If the file cannot be used.

    """
    kind, values = _content(path)
    if kind == 'grid':
        return read_grid(path).image_size
    if kind == 'tsai':
        return read_tsai(path).image_size
    if kind == 'projection':
        return None
    if kind == 'kalibr':
        return read_kalibr(values, path, choice).image_size
    return size_of(read_ost(path, choice) if kind == 'ost' else values, path)


def read_camera(
    path: str | Path,
    image_size: tuple[int, int],
    extrinsics: str | Path = '',
    choice: Choice = ANY,
) -> StoredCamera:
    """Read a file that holds a camera; its pose from another, if one is named."""
    kind, values = _content(path)
    if kind == 'kalibr':
        camera = read_kalibr(values, path, choice)
    elif kind == 'ost':
        camera = camera_of(read_ost(path, choice), path, image_size)
    else:
        _check_single(path, choice)
        camera = _tsai(path) if kind == 'tsai' else camera_of(values, path, image_size)
    return dataclasses.replace(camera, pose=read_extrinsics(extrinsics)) if extrinsics else camera


def read_extrinsics(path: str | Path) -> Pose:
    """
    Read a camera's pose: YAML as TF has it, what `tf2_echo` prints, or a file of OpenCV's.

    Raises
    ------
    CalibrationError
        If the file cannot be read, holds no pose or what is not known; names it.

    """
    start = _start(path)
    if start.startswith(b'<'):
        read_xml(path, CalibrationError)
        return pose_in(read_opencv(path), path)
    return pose_in(read_opencv(path) if _is_opencv_yaml(start) else read_yaml(path), path)


def camera_mapping(
    camera: StoredCamera, where: str | Path, image_size: tuple[int, int], unit: str = 'm'
) -> GroundMapping:
    """
    Return the mapping of a camera that can be true.

    Parameters
    ----------
    camera : StoredCamera
        The camera, with its pose.
    where : str or Path
        What it is from, to name.
    image_size : (int, int)
        Width and height of its images, px.
    unit : str
        Of its pose, one of `METRES`.

    Raises
    ------
    CalibrationError
        If it is for images of another size, or cannot be true.

    """
    metres = _metres(unit)
    return _checked(where, lambda: camera.mapping(image_size, metres))


def write_calibration(mapping: GroundMapping, path: str | Path, to: str, name: str) -> float:
    """
    Write a calibration in a format.

    Parameters
    ----------
    mapping : GroundMapping
        The calibration.
    path : str or Path
        The file.
    to : str
        One of `FORMATS`.
    name : str
        Of the camera.

    Returns
    -------
    float
        How far at most what the file says is from the mapping, px: its lens, or the camera that
        is fitted to its grid.

    Raises
    ------
    CalibrationError
        If the format cannot hold it within a pixel, for example a lens in a matrix.

    """
    if to not in FORMATS:
        raise CalibrationError(f'format is {to!r}, expected one of {", ".join(FORMATS)}')
    return FORMATS[to](mapping, path, name)


def knows_its_error(mapping: GroundMapping) -> bool:
    """Tell whether a calibration knows how good it is, which no format but a grid keeps."""
    return isinstance(mapping, CameraMapping) and bool(mapping.camera.covariance.any())


def _start(path: str | Path) -> bytes:
    """Return the bytes of a file from its first character on."""
    check_size(path, SETTINGS, CalibrationError)
    try:
        return Path(path).read_bytes().lstrip(b'\xef\xbb\xbf \t\r\n')
    except OSError as error:
        raise CalibrationError(f'{path}: {error.strerror or error}') from error


def _is_opencv_yaml(content: bytes) -> bool:
    """Tell whether a YAML file is one of OpenCV's: other readers do not know its tags."""
    return b'!!opencv-' in content


def _content(path: str | Path) -> tuple[str, Mapping[Any, Any]]:
    """Return a file's format, and where it has keys, what it holds."""
    start = _start(path)
    if start.startswith(b'<'):
        root = read_xml(path, CalibrationError).tag
        if root in _ROOTS:
            kind = _ROOTS[root]
            return kind, read_opencv(path) if kind == 'opencv' else {}
        hint = ': a scene has no pixels' if root == 'scene' else ''
        raise CalibrationError(f'{path}: <{root}> is no calibration{hint}')
    if is_ost(start):
        return 'ost', {}
    if _is_opencv_yaml(start):
        values: Mapping[Any, Any] = read_opencv(path)
        if not states_camera(values):
            _refuse_foreign(path, start)
        return 'opencv', values
    try:
        values = read_yaml(path)
    except CalibrationError:
        _refuse_foreign(path, start)
        raise
    if holds_projection(values):
        return 'projection', values
    if kalibr_cameras(values):
        return 'kalibr', values
    if states_camera(values):
        return 'camera_info', values
    _refuse_foreign(path, start)
    raise CalibrationError(
        f'{path}: no calibration that is known: expected a transformation grid, a matrix '
        '(image_from_ground, ground_from_image, image_from_world), a camera_matrix as of ROS or '
        "OpenCV, Kalibr's cam0, or a file of Tsai's"
    )


def _refuse_foreign(path: str | Path, content: bytes) -> None:
    """Refuse a file of a program whose form is not read, and say how to write the same."""
    form = how_to_write(content)
    if form:
        raise CalibrationError(f'{path}: not read in this form; write a YAML of {form}')


def _check_single(path: str | Path, choice: Choice) -> None:
    if choice.camera:
        raise CalibrationError(f'{path}: it holds one camera alone, no {choice.camera}')


def _tsai(path: str | Path) -> StoredCamera:
    stored = read_tsai(path)
    try:
        return stored.camera()
    except CalibrationError as error:
        raise CalibrationError(f'{path}: {error}') from error


def _metres(unit: str) -> float:
    if unit not in METRES:
        raise ValueError(f'unit is {unit!r}, expected one of {sorted(METRES)}')
    return METRES[unit]


def _checked(path: str | Path, make: Callable[[], GroundMapping]) -> GroundMapping:
    """Return a mapping that can be true; what is refused names the file."""
    try:
        mapping = make()
        check_plausible(mapping)
    except CalibrationError as error:
        raise type(error)(f'{path}: {error}') from error
    return mapping


def _to_grid(mapping: GroundMapping, path: str | Path, name: str) -> float:
    grid = sampled_grid(mapping, name)
    missed = grid_miss_px(mapping, grid)
    if not missed <= LARGEST_RESIDUAL_PX:
        raise CalibrationError(
            'the camera fitted to a grid (a lens of five terms, as lenses usually are) '
            f'misses this one by up to {missed:.2g} px, expected at most '
            f'{LARGEST_RESIDUAL_PX:g} px: convert to opencv or camera_info'
        )
    write_grid(grid, path)
    return missed


def _to_opencv(mapping: GroundMapping, path: str | Path, name: str) -> float:
    write_opencv(stored_camera(mapping), mapping.image_size, path)
    return 0.0


def _to_camera_info(mapping: GroundMapping, path: str | Path, name: str) -> float:
    write_camera_info(stored_camera(mapping), mapping.image_size, name, path)
    return 0.0


def _to_tsai(mapping: GroundMapping, path: str | Path, name: str) -> float:
    return write_tsai(stored_camera(mapping), mapping.image_size, name, path)


def _to_matrix(which: str) -> Callable[[GroundMapping, str | Path, str], float]:
    def write(mapping: GroundMapping, path: str | Path, name: str) -> float:
        if isinstance(mapping, ProjectiveMapping):
            write_projection(mapping, which, path)
            return 0.0
        camera = stored_camera(mapping)
        bent = bend_px(camera.intrinsics, camera.distortion, mapping.image_size)
        if bent > STRAIGHT_PX or camera.pose is None:
            raise CalibrationError(
                f'a matrix holds no lens, and this one moves pixels by up to {bent:.2g} px '
                f'(expected at most {STRAIGHT_PX:g} px): undistort the images, or '
                'convert to grid, opencv or camera_info'
            )
        across, down, x, y = camera.intrinsics
        intrinsics = np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]])
        pose = np.column_stack([camera.pose.rotation, camera.pose.translation])
        write_projection(ProjectiveMapping(intrinsics @ pose, mapping.image_size), which, path)
        return bent

    return write


FORMATS: dict[str, Callable[[GroundMapping, str | Path, str], float]] = {
    'grid': _to_grid,
    'camera_info': _to_camera_info,
    'opencv': _to_opencv,
    'tsai': _to_tsai,
    'image_from_world': _to_matrix('image_from_world'),
    'image_from_ground': _to_matrix('image_from_ground'),
    'ground_from_image': _to_matrix('ground_from_image'),
}
"""What writes each format: mapping, file, name of the camera -> how far the lens is off, px."""
