"""Cameras as ROS has them: `sensor_msgs/CameraInfo` or its YAML, with the pose from TF."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from mctrack_ros.ground.camera.stored import Pose, StoredCamera
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.camera import camera_of
from mctrack_ros.ground.files.keyed.keys import meaning_of
from mctrack_ros.ground.files.keyed.pose import pose_in
from mctrack_ros.ground.yaml_files import read_yaml_documents
from mctrack_ros.input_size import SETTINGS, check_size

_INFO = ('width', 'height', 'distortion_model', 'd', 'k', 'binning_x', 'binning_y')
_REGION = ('x_offset', 'y_offset', 'width', 'height')
_NOT_PRINTED = re.compile(r'<(array|sequence) type: .*>|<string length: .*>')
_TF2_ECHO = re.compile(
    rb'- Translation: (\[[^\]]*\])\s*- Rotation: in Quaternion (?:\(xyzw\) )?(\[[^\]]*\])'
)


def camera_from_info(info: Any, transform: Any = None) -> StoredCamera:
    """
    Return the camera of a message, for raw (not rectified) images.

    Where it states binning or a region of interest, the images are those, as `image_geometry`
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
    values: dict[str, Any] = {key: getattr(info, key) for key in _INFO}
    values |= {key: np.asarray(values[key], np.float64) for key in ('d', 'k')}
    values['roi'] = {key: getattr(info.roi, key) for key in _REGION}
    camera = camera_of(values, 'the camera info')
    if transform is None:
        return camera
    return dataclasses.replace(camera, pose=pose_from_transform(transform, 'the transform'))


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
    values = {
        'translation': [shift.x, shift.y, shift.z],
        'rotation': [turn.x, turn.y, turn.z, turn.w],
    }
    return pose_in(values, where)


def read_yaml(path: str | Path) -> Mapping[str, Any]:
    """
    Read a YAML file that holds a mapping: of several documents, all have to hold the same one.

    So `ros2 topic echo` prints messages; their stamps may differ. What `tf2_echo` prints is read
    as a mapping, too.

    Raises
    ------
    CalibrationError
        If it cannot be read or holds something else; names it.

    """
    printed = _tf2_echo(path)
    documents = printed or [
        each for each in read_yaml_documents(path, CalibrationError) if each is not None
    ]
    if not documents or not all(isinstance(each, Mapping) for each in documents):
        raise CalibrationError(f'{path}: expected a mapping')
    first = _without_stamps(documents[0])
    if any(_without_stamps(each) != first for each in documents[1:]):
        raise CalibrationError(f'{path}: it holds several messages that differ: keep one')
    content: Mapping[str, Any] = documents[0]
    for key, value in content.items():
        if _is_cut(value) or (meaning_of(key) == 'model' and str(value).endswith('...')):
            raise CalibrationError(
                f'{path}: {key} is not printed whole: print it again by `ros2 topic '
                'echo --full-length`, without --no-arr and --no-str'
            )
    return content


def _is_cut(value: Any) -> bool:
    """Tell whether `ros2 topic echo` printed only a part of a value, or only what it is."""
    if isinstance(value, Mapping):
        return any(map(_is_cut, value.values()))
    if isinstance(value, list):
        return value[-1:] == ['...'] or any(map(_is_cut, value))
    return isinstance(value, str) and _NOT_PRINTED.fullmatch(value) is not None


def _tf2_echo(path: str | Path) -> list[Any]:
    """Return what `tf2_echo` printed, if the file holds that."""
    check_size(path, SETTINGS, CalibrationError)
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise CalibrationError(f'{path}: {error.strerror or error}') from error
    return [
        {'translation': yaml.safe_load(shift), 'rotation': yaml.safe_load(turn)}
        for shift, turn in _TF2_ECHO.findall(content)
    ]


def _without_stamps(content: Any) -> Any:
    """Return a message without when it was sent."""
    if isinstance(content, Mapping):
        return {
            key: _without_stamps(value)
            for key, value in content.items()
            if key not in ('stamp', 'seq')
        }
    return [_without_stamps(each) for each in content] if isinstance(content, list) else content


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


def _table(rows: int, columns: int, data: list[float]) -> dict[str, Any]:
    return {'rows': rows, 'cols': columns, 'data': data}
