"""A camera as calibration files hold it, on its way to or from a mapping."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import rq
from scipy.spatial.transform import Rotation

from mctrack_ros.ground.camera.pinhole import Camera, CameraMapping
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Pose:
    """
    Where a camera is.

    Attributes
    ----------
    rotation : (3, 3) array
        From world to camera axes (right, down, forward).
    translation : (3,) array
        The world's origin in camera axes, in the file's unit.

    """

    rotation: Floats
    translation: Floats

    @classmethod
    def of_frame(cls, translation: ArrayLike, quaternion: ArrayLike) -> Pose:
        """Return the pose of TF: where the optical frame is, and its axes (x, y, z, w)."""
        turn = Rotation.from_quat(np.asarray(quaternion, np.float64)).as_matrix().T
        return cls(turn, -turn @ np.asarray(translation, np.float64))


@dataclass(frozen=True, eq=False, slots=True)
class StoredCamera:
    """
    What a calibration file says of a camera.

    Attributes
    ----------
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    distortion : (5,) or (8,) array
        k1, k2, p1, p2, k3 (, k4, k5, k6) of OpenCV.
    pose : Pose or None
        Where it is; None: the file does not say.
    image_size : (int, int) or None
        Width and height of the images it was calibrated for, px.
    lens_residual_px : float
        How far at most the coefficients miss the lens of the file, px.
    notes : tuple of str
        What the file states and the camera leaves out, with how much it is.

    """

    intrinsics: Floats
    distortion: Floats
    pose: Pose | None = None
    image_size: tuple[int, int] | None = None
    lens_residual_px: float = 0.0
    notes: tuple[str, ...] = ()

    def mapping(self, image_size: tuple[int, int], metres_per_unit: float = 1.0) -> CameraMapping:
        """
        Return the mapping for images of a size, px.

        Raises
        ------
        CalibrationError
            If the camera was calibrated for another size, or its pose is missing or no pose.

        """
        if self.image_size is not None and tuple(self.image_size) != tuple(image_size):
            raise CalibrationError(
                f'the camera is calibrated for images of {self.image_size[0]} x '
                f'{self.image_size[1]} px, not of {image_size[0]} x {image_size[1]} px'
            )
        if self.pose is None:
            raise CalibrationError('the file does not say where the camera is: name extrinsics')
        try:
            camera = Camera(
                self.intrinsics, self.distortion, self.pose.rotation,
                self.pose.translation * metres_per_unit,
            )  # fmt: skip
            return CameraMapping(camera, image_size)
        except ValueError as error:
            raise CalibrationError(str(error)) from error

    def scaled(self, share: float) -> StoredCamera:
        """Return the camera of the same images made larger or smaller."""
        size = self.image_size
        return replace(
            self,
            intrinsics=self.intrinsics * share,
            image_size=None if size is None else (round(size[0] * share), round(size[1] * share)),
        )


def stored_camera(mapping: GroundMapping) -> StoredCamera:
    """
    Return the camera of a mapping.

    Raises
    ------
    CalibrationError
        If it has none: a grid mapped by cells, a mirrored ground, pixels that are not square-cut.

    """
    if isinstance(mapping, CameraMapping):
        camera = mapping.camera
        pose = Pose(camera.rotation, camera.translation)
        return StoredCamera(camera.intrinsics, camera.distortion, pose, mapping.image_size)
    if not isinstance(mapping, ProjectiveMapping):
        raise CalibrationError(f'a {type(mapping).__name__} has no camera that could be written')
    upper, rotation = rq(mapping.image_from_world[:, :3])
    signs = np.diag(np.sign(np.diag(upper)))
    upper, rotation = upper @ signs, signs @ rotation
    translation = np.linalg.solve(upper, mapping.image_from_world[:, 3])
    if np.linalg.det(rotation) < 0:
        raise CalibrationError("the ground's axes are mirrored: no camera sees them so")
    upper /= upper[2, 2]
    if abs(upper[0, 1]) > 1e-6 * upper[0, 0]:
        raise CalibrationError('the columns and rows of the image are not at right angles')
    intrinsics = np.array([upper[0, 0], upper[1, 1], upper[0, 2], upper[1, 2]])
    return StoredCamera(intrinsics, np.zeros(5), Pose(rotation, translation), mapping.image_size)
