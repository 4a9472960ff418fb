"""Cameras as ROS has them: `sensor_msgs/CameraInfo` or its YAML, with the pose from TF."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.lens_models import lens_of
from mctrack_ros.ground.opencv_file import intrinsics_of
from mctrack_ros.ground.stored_camera import Pose, StoredCamera
from mctrack_ros.ground.yaml_files import read_yaml_file

Floats = NDArray[np.float64]
POSE_KEYS = ('extrinsics', 'transform')


def camera_from_info(info: Any, transform: Any = None) -> StoredCamera:
    """
    Return the camera of a message, for raw (not rectified) pictures.

    Where it states binning or a region of interest, the pictures are those, as `image_geometry`
    reads it.

    Parameters
    ----------
    info : sensor_msgs/CameraInfo
        rclpy's or rosbags'.
    transform : geometry_msgs/TransformStamped or geometry_msgs/Transform, optional
        From the ground frame to the camera's optical frame, as TF has it: where the optical frame
        is on the ground, m.

    Raises
    ------
    CalibrationError
        If the message holds no calibration, or the lens cannot be followed.

    """
    pose = None if transform is None else pose_from_transform(transform, 'the transform')
    matrix: Floats = np.array(info.k, np.float64).reshape(3, 3)
    window, binning = info.roi, np.maximum([info.binning_x, info.binning_y], 1)
    size = np.array([window.width or info.width, window.height or info.height])
    matrix[:2, 2] -= window.x_offset, window.y_offset
    matrix[:2] /= binning[:, None]
    width, height = (size // binning).tolist()
    return _stored((width, height), matrix, info.distortion_model, info.d, pose, 'the camera info')


def pose_from_transform(transform: Any, where: str) -> Pose:
    """
    Return the pose of a `geometry_msgs/TransformStamped` or `Transform`, as TF has it.

    Raises
    ------
    CalibrationError
        If it is none; names where it is from.

    """
    inner = getattr(transform, 'transform', transform)
    shift, turn = inner.translation, inner.rotation
    return pose_of([shift.x, shift.y, shift.z], [turn.x, turn.y, turn.z, turn.w], where)


def read_camera_info(path: str | Path) -> StoredCamera:
    """
    Read the YAML of `camera_calibration`; with a pose where it has a key ``extrinsics``.

    Raises
    ------
    CalibrationError
        If the file cannot be read or holds no calibration; names it.

    """
    content = read_yaml(path)
    try:
        size = int(content['image_width']), int(content['image_height'])
        matrix = content['camera_matrix']['data']
        terms = content.get('distortion_coefficients', {}).get('data', [])
        model = str(content.get('distortion_model', ''))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CalibrationError(
            f'{path}: no camera info: expected image_width, image_height, camera_matrix.data '
            'and distortion_coefficients.data'
        ) from error
    pose = _pose_below(content, path) if any(key in content for key in POSE_KEYS) else None
    return _stored(size, matrix, model, terms, pose, str(path))


def read_pose(path: str | Path) -> Pose:
    """
    Read where a camera's optical frame is: YAML with ``translation`` and ``rotation``.

    Both may lie below ``extrinsics`` or ``transform`` (as `ros2 topic echo` prints a
    TransformStamped); a mapping x, y, z (, w) or a list each, metres and a quaternion.

    Raises
    ------
    CalibrationError
        If the file cannot be read or holds no pose; names it.

    """
    return _pose_below(read_yaml(path), path)


def write_camera_info(
    camera: StoredCamera, image_size: tuple[int, int], name: str, path: str | Path
) -> None:
    """Write the YAML of `camera_calibration`, with the pose below ``extrinsics``."""
    across, down, x, y = camera.intrinsics.tolist()
    lens = camera.distortion.tolist()
    matrix = [across, 0.0, x, 0.0, down, y, 0.0, 0.0, 1.0]
    content: dict[str, Any] = {
        'image_width': int(image_size[0]),
        'image_height': int(image_size[1]),
        'camera_name': name,
        'camera_matrix': _table(3, 3, matrix),
        'distortion_model': 'plumb_bob' if len(lens) == 5 else 'rational_polynomial',
        'distortion_coefficients': _table(1, len(lens), lens),
        'rectification_matrix': _table(3, 3, np.eye(3).ravel().tolist()),
        'projection_matrix': _table(
            3, 4, [across, 0.0, x, 0.0, 0.0, down, y, 0.0, 0.0, 0.0, 1.0, 0.0]
        ),
    }
    if camera.pose is not None:
        place = -camera.pose.rotation.T @ camera.pose.translation
        turn = Rotation.from_matrix(camera.pose.rotation.T).as_quat()
        content['extrinsics'] = {
            'translation': dict(zip('xyz', place.tolist())),
            'rotation': dict(zip('xyzw', turn.tolist())),
        }
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=99)
    Path(path).write_text(text, encoding='utf-8')


def read_yaml(path: str | Path) -> Mapping[str, Any]:
    """
    Read a YAML file that holds a mapping.

    Raises
    ------
    CalibrationError
        If it cannot be read or holds something else.

    """
    content = read_yaml_file(path, CalibrationError, several=True)
    if not isinstance(content, Mapping):
        raise CalibrationError(f'{path}: expected a mapping')
    return content


def pose_of(translation: Any, quaternion: Any, where: str | Path) -> Pose:
    """
    Return the pose of lists or mappings: metres, and a quaternion x, y, z, w.

    Raises
    ------
    CalibrationError
        If they hold something else.

    """
    shift, turn = _listed(translation, 'xyz'), _listed(quaternion, 'xyzw')
    if len(shift) != 3 or len(turn) != 4 or not np.isfinite([*shift, *turn]).all():
        raise CalibrationError(
            f'{where}: expected a translation of x, y, z and a rotation of x, y, z, w'
        )
    if abs(np.linalg.norm(turn) - 1) > 1e-3:
        raise CalibrationError(f'{where}: the quaternion {turn} has not the length 1')
    return Pose.of_frame(shift, turn)


def _stored(
    size: tuple[int, int], matrix: Any, model: str, terms: Any, pose: Pose | None, where: str
) -> StoredCamera:
    try:
        numbers: Floats = np.asarray(matrix, np.float64).reshape(3, 3)
        coefficients: Floats = np.asarray(terms, np.float64)
    except (TypeError, ValueError) as error:
        raise CalibrationError(
            f'{where}: the camera matrix or the lens holds no numbers'
        ) from error
    if min(size) <= 0 or not numbers.any():
        raise CalibrationError(f'{where}: the camera is not calibrated')
    intrinsics = intrinsics_of(numbers, where)
    try:
        intrinsics, distortion, residual = lens_of(model, intrinsics, coefficients, size)
    except CalibrationError as error:
        raise CalibrationError(f'{where}: {error}') from error
    return StoredCamera(intrinsics, distortion, pose, size, residual)


def _pose_below(content: Mapping[str, Any], path: str | Path) -> Pose:
    for key in POSE_KEYS:
        if isinstance(content.get(key), Mapping):
            content = content[key]
    turn = content.get('rotation', content.get('quaternion'))
    return pose_of(content.get('translation'), turn, path)


def _listed(values: Any, keys: str) -> list[float]:
    if isinstance(values, Mapping):
        values = [values.get(key) for key in keys]
    try:
        return [float(value) for value in values]
    except (TypeError, ValueError):
        return []


def _table(rows: int, columns: int, data: list[float]) -> dict[str, Any]:
    return {'rows': rows, 'cols': columns, 'data': data}
