"""A camera over the ground plane as a 3 x 4 projection: metres to pixels and back."""

from __future__ import annotations

from typing import Self

import cv2
import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_2D, compiled
from mctrack_ros.ground.mapping import GroundMapping, points_of

Floats = NDArray[np.float64]


class ProjectiveMapping(GroundMapping):
    """
    Image <-> ground plane z = 0 through a pinhole camera without lens distortion.

    Parameters
    ----------
    image_from_world : (3, 4) array_like
        Projection of homogeneous world coordinates (m) to the image (px).
    image_size : (int, int)
        Width and height, px.

    Raises
    ------
    ValueError
        If the shape is wrong, a number is not finite, or the ground projects to a line.

    """

    def __init__(self, image_from_world: ArrayLike, image_size: tuple[int, int]) -> None:
        matrix = np.asarray(image_from_world, np.float64)
        if matrix.shape != (3, 4) or not np.isfinite(matrix).all():
            raise ValueError(f'image_from_world has shape {matrix.shape}, expected finite (3, 4)')
        homography = np.ascontiguousarray(matrix[:, [0, 1, 3]])
        _check_regular(homography)
        centre = np.array([image_size[0] / 2, image_size[1] * 0.75, 1.0])
        depth = homography[2] @ np.linalg.solve(homography, centre)
        on_ground = np.linalg.solve(homography, centre)
        sign = np.sign(depth * on_ground[2]) or 1.0
        self.image_from_world = matrix * sign
        self.image_from_ground_homography = homography * sign
        self.ground_from_image_homography = np.linalg.inv(self.image_from_ground_homography)
        self.image_size = (int(image_size[0]), int(image_size[1]))

    @classmethod
    def from_homography(cls, image_from_ground: ArrayLike, image_size: tuple[int, int]) -> Self:
        """
        Recover the vertical direction of a ground homography.

        Square pixels and a principal point at the picture's centre are assumed; the focal length
        follows from the two ground axes being orthogonal and of equal length.

        Parameters
        ----------
        image_from_ground : (3, 3) array_like
            Homogeneous ground coordinates (m) to image (px).
        image_size : (int, int)
            Width and height, px.

        """
        homography = np.asarray(image_from_ground, np.float64)
        if homography.shape != (3, 3) or not np.isfinite(homography).all():
            raise ValueError(f'homography has shape {homography.shape}, expected finite (3, 3)')
        _check_regular(homography)
        width, height = image_size
        to_centre = np.array([[1.0, 0, -width / 2], [0, 1.0, -height / 2], [0, 0, 1.0]])
        first, second = (to_centre @ homography)[:, :2].T
        focal = _focal_length(first, second, float(max(width, height)))
        intrinsics = np.diag([focal, focal, 1.0])
        rotated = np.linalg.solve(intrinsics, to_centre @ homography)
        scale = np.sqrt(np.linalg.norm(rotated[:, 0]) * np.linalg.norm(rotated[:, 1]))
        rotated = rotated / scale
        camera_height = -np.cross(rotated[:, 0], rotated[:, 1]) @ rotated[:, 2]
        if camera_height < 0:
            rotated = -rotated
        vertical = np.cross(rotated[:, 0], rotated[:, 1])
        pose = np.column_stack([rotated[:, 0], rotated[:, 1], vertical, rotated[:, 2]])
        return cls(np.linalg.solve(to_centre, intrinsics @ pose), image_size)

    @classmethod
    def from_points(cls, ground: ArrayLike, image: ArrayLike, image_size: tuple[int, int]) -> Self:
        """
        Fit one homography to corresponding points by robust least squares.

        Parameters
        ----------
        ground : (n, 2) array_like
            Ground positions, m.
        image : (n, 2) array_like
            Their pixels.
        image_size : (int, int)
            Width and height, px.

        Raises
        ------
        ValueError
            If there are fewer than four points or all lie on a line.

        """
        ground, image = np.asarray(ground, np.float64), np.asarray(image, np.float64)
        if len(ground) < 4:
            raise ValueError(f'{len(ground)} points, expected at least 4')
        homography, _ = cv2.findHomography(ground, image, cv2.RANSAC, 3.0)
        if homography is None or np.linalg.matrix_rank(ground - ground.mean(axis=0)) < 2:
            raise ValueError('the points lie on a line: they fix no homography')
        return cls.from_homography(homography, image_size)

    @property
    def camera_position(self) -> Floats:
        """Return where the camera is, (3,) m."""
        place: Floats = -np.linalg.solve(self.image_from_world[:, :3], self.image_from_world[:, 3])
        return place

    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN beyond the horizon."""
        return _projected(self.ground_from_image_homography, points_of(pixel))

    def image_from_ground(self, position: ArrayLike, height: ArrayLike = 0.0) -> Floats:
        """
        Return the (n, 2) pixels of (n, 2) ground positions, m; NaN behind the camera.

        Parameters
        ----------
        position : (n, 2) array_like
            Ground positions, m.
        height : array_like
            Height above the ground, m: a number or (n,).

        """
        points = points_of(position)
        if not np.any(height):
            return _projected(self.image_from_ground_homography, points)
        heights = np.broadcast_to(np.asarray(height, np.float64), len(points))
        world = np.column_stack([points, heights, np.ones(len(points))])
        image = world @ self.image_from_world.T
        ahead = image[:, 2:] > 0
        return np.where(ahead, image[:, :2] / np.where(ahead, image[:, 2:], 1), np.nan)

    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""
        return _derivatives(self.image_from_ground_homography, points_of(position))


def _check_regular(homography: Floats) -> None:
    if np.linalg.matrix_rank(homography) < 3:
        raise ValueError('the ground plane projects to a line: the homography is singular')


@compiled(types.f8[:, ::1](FLOATS_2D, FLOATS_2D))
def _projected(matrix: Floats, points: Floats) -> Floats:
    """Map (n, 2) points by a homography; NaN for what it sends beyond infinity."""
    mapped = np.full((len(points), 2), np.nan)
    for index in range(len(points)):
        x, y = points[index]
        depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
        if depth > 0.0:
            for axis in range(2):
                mapped[index, axis] = (
                    matrix[axis, 0] * x + matrix[axis, 1] * y + matrix[axis, 2]
                ) / depth
    return mapped


@compiled(types.f8[:, :, ::1](FLOATS_2D, FLOATS_2D))
def _derivatives(matrix: Floats, points: Floats) -> Floats:
    """Return the (n, 2, 2) derivatives of a homography at (n, 2) points."""
    derivatives = np.empty((len(points), 2, 2))
    for index in range(len(points)):
        x, y = points[index]
        depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
        share = 1.0 / depth if depth > 0.0 else np.nan
        for axis in range(2):
            mapped = (matrix[axis, 0] * x + matrix[axis, 1] * y + matrix[axis, 2]) * share
            for by in range(2):
                derivatives[index, axis, by] = (matrix[axis, by] - mapped * matrix[2, by]) * share
    return derivatives


def _focal_length(first: Floats, second: Floats, fallback: float) -> float:
    """Return the focal length, px, for which two homography columns are orthonormal."""
    flat_dot, flat_difference = (
        first[:2] @ second[:2],
        first[:2] @ first[:2] - second[:2] @ second[:2],
    )
    deep_dot, deep_difference = first[2] * second[2], first[2] ** 2 - second[2] ** 2
    design = np.array([flat_dot, flat_difference])
    target = -np.array([deep_dot, deep_difference])
    inverse_square = float(design @ target / (design @ design)) if design.any() else 0.0
    return float(np.sqrt(1 / inverse_square)) if inverse_square > 0 else fallback
