"""Cameras as OpenCV stores them (`cv2.FileStorage`): XML or YAML, in one file or two."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.lens_models import lens_of
from mctrack_ros.ground.stored_camera import Pose, StoredCamera

Floats = NDArray[np.float64]
MATRIX = ('camera_matrix', 'cameraMatrix', 'Camera_Matrix', 'K')
DISTORTION = ('distortion_coefficients', 'distCoeffs', 'Distortion_Coefficients', 'D')
TURN = ('rvec', 'R', 'rotation_vector', 'rotation_matrix')
SHIFT = ('tvec', 'T', 't', 'translation_vector')


def read_opencv(path: str | Path, image_size: tuple[int, int]) -> StoredCamera:
    """
    Read a camera; its pose where the file has one (rvec or R, tvec or T: from world to camera).

    Parameters
    ----------
    path : str or Path
        XML or YAML file with `camera_matrix` and, unless the lens is straight,
        `distortion_coefficients`; `image_width` and `image_height` are held against the size.
    image_size : (int, int)
        Width and height of the pictures, px.

    Raises
    ------
    CalibrationError
        If the file cannot be read or holds no camera; names it.

    """
    with _Storage(path) as storage:
        matrix = storage.numbers(MATRIX, (9,))
        if matrix is None:
            raise CalibrationError(f'{path}: no {MATRIX[0]}')
        intrinsics = intrinsics_of(matrix.reshape(3, 3), path)
        terms = storage.numbers(DISTORTION)
        size = storage.size()
        pose = storage.pose()
    terms = np.zeros(5) if terms is None else terms
    model = 'plumb_bob' if len(np.trim_zeros(terms, 'b')) <= 5 else 'rational_polynomial'
    try:
        intrinsics, distortion, residual = lens_of(model, intrinsics, terms, size or image_size)
    except CalibrationError as error:
        raise CalibrationError(f'{path}: {error}') from error
    return StoredCamera(intrinsics, distortion, pose, size, residual)


def opencv_size(path: str | Path) -> tuple[int, int] | None:
    """Return the size of the pictures, px, that a file of OpenCV's states, if it does."""
    with _Storage(path) as storage:
        return storage.size()


def read_opencv_pose(path: str | Path) -> Pose:
    """
    Read the pose of a camera from a file of OpenCV's.

    Raises
    ------
    CalibrationError
        If it is not there.

    """
    with _Storage(path) as storage:
        pose = storage.pose()
    if pose is None:
        raise CalibrationError(f'{path}: no pose: expected rvec and tvec, or R and T')
    return pose


def write_opencv(camera: StoredCamera, image_size: tuple[int, int], path: str | Path) -> None:
    """Write a camera and, where it is known, its pose: XML or YAML by the file's ending."""
    across, down, x, y = camera.intrinsics.tolist()
    Path(path).touch()  # OpenCV does not say why it cannot write
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write('image_width', int(image_size[0]))
    storage.write('image_height', int(image_size[1]))
    storage.write(MATRIX[0], np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]]))
    storage.write(DISTORTION[0], camera.distortion[None])
    if camera.pose is not None:
        storage.write('rvec', cv2.Rodrigues(camera.pose.rotation)[0])
        storage.write('tvec', camera.pose.translation[:, None])
    storage.release()


def intrinsics_of(matrix: Floats, path: str | Path) -> Floats:
    """Return the focal lengths and principal point, (4,) px, of a (3, 3) camera matrix."""
    wanted = np.array(
        [[matrix[0, 0], 0, matrix[0, 2]], [0, matrix[1, 1], matrix[1, 2]], [0, 0, 1]]
    )
    if not np.allclose(matrix, wanted, rtol=0, atol=1e-9) or min(matrix[0, 0], matrix[1, 1]) <= 0:
        raise CalibrationError(
            f'{path}: the camera matrix is {matrix.tolist()}, expected [[fx, 0, cx], [0, fy, cy], '
            '[0, 0, 1]]'
        )
    return matrix[[0, 1, 0, 1], [0, 1, 2, 2]]


class _Storage:
    """An open file of OpenCV's."""

    def __init__(self, path: str | Path) -> None:
        self._path = path
        if not Path(path).is_file():
            raise CalibrationError(f'{path}: no such file')
        try:
            self._storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        except (cv2.error, SystemError) as error:
            raise CalibrationError(f'{path}: OpenCV cannot read it') from error

    def __enter__(self) -> _Storage:
        return self

    def __exit__(self, *_: object) -> None:
        self._storage.release()

    def numbers(self, names: Iterable[str], shape: tuple[int, ...] | None = None) -> Floats | None:
        """Return the finite numbers below the first of the names that is there."""
        for name in names:
            node = self._storage.getNode(name)
            if node.empty():
                continue
            values = self._values(node, name)
            if (shape is not None and values.shape != shape) or not np.isfinite(values).all():
                raise CalibrationError(
                    f'{self._path}: {name} holds {len(values)} numbers, expected finite '
                    f'{"numbers" if shape is None else shape[0]}'
                )
            return values
        return None

    def size(self) -> tuple[int, int] | None:
        """Return the size of the pictures, px, if the file has it."""
        width, height = (self._storage.getNode(f'image_{name}') for name in ('width', 'height'))
        if width.empty() or height.empty():
            return None
        return int(width.real()), int(height.real())

    def pose(self) -> Pose | None:
        """Return the pose, from world to camera, if the file has it."""
        turn, shift = self.numbers(TURN), self.numbers(SHIFT, (3,))
        if turn is None or shift is None:
            return None
        if turn.shape not in ((3,), (9,)):
            raise CalibrationError(
                f'{self._path}: the rotation holds {len(turn)} numbers, not 3 or 9'
            )
        rotation = cv2.Rodrigues(turn)[0] if len(turn) == 3 else turn.reshape(3, 3)
        return Pose(np.asarray(rotation, np.float64), shift)

    def _values(self, node: cv2.FileNode, name: str) -> Floats:
        """Return a list's or matrix's numbers, one by one: some OpenCV garble whole ones."""
        values = node.getNode('data') if node.isMap() else node
        if not values.isSeq():
            raise CalibrationError(f'{self._path}: {name} is no matrix')
        entries = [values.at(index) for index in range(values.size())]
        if not all(entry.isInt() or entry.isReal() for entry in entries):
            raise CalibrationError(f'{self._path}: {name} holds more than numbers')
        return np.array([entry.real() for entry in entries])
