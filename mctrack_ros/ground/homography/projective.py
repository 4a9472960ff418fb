"""A camera over the ground plane as a 3 x 4 projection: metres to pixels and back."""

from __future__ import annotations

from functools import cached_property
from typing import Literal, Self

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_2D, compiled, inner
from mctrack_ros.ground.homography.covariance import add_spread
from mctrack_ros.ground.homography.fit import HomographyFit, fit_homography, start_homography
from mctrack_ros.ground.mapping import GroundMapping, Mask, points_of, propagated
from mctrack_ros.ground.origin import local_origin
from mctrack_ros.ground.support import distance_squared, doubt, doubts

Floats = NDArray[np.float64]
DOUBT = 0.005
"""By so much of the image's width a homography may miss the pixels of its points."""
GROWTH = 8.0
"""How much the misfit of one homography grows outside its points, for each reach of theirs."""
SINGULAR = 100 * np.finfo(np.float64).eps


class ProjectiveMapping(GroundMapping):
    """
    Image <-> ground plane z = 0 through a pinhole camera without lens distortion.

    Parameters
    ----------
    image_from_world : (3, 4) array_like
        Projection of homogeneous world coordinates (m) to the image (px).
    image_size : (int, int)
        Width and height, px.
    fit : HomographyFit, optional
        Of the ground plane's points, if it was made from points: its uncertainty is carried along.

    Raises
    ------
    ValueError
        If the shape is wrong, a number is not finite, or the ground projects to a line.

    """

    def __init__(
        self,
        image_from_world: ArrayLike,
        image_size: tuple[int, int],
        fit: HomographyFit | None = None,
    ) -> None:
        matrix = np.asarray(image_from_world, np.float64)
        if matrix.shape != (3, 4) or not np.isfinite(matrix).all():
            raise ValueError(f'image_from_world has shape {matrix.shape}, expected finite (3, 4)')
        _check_regular(matrix[:, [0, 1, 3]])
        if fit is None:
            self.origin = _near_camera(matrix)
            matrix = _moved(matrix, -self.origin)
        homography = np.ascontiguousarray(matrix[:, [0, 1, 3]])
        centre = np.array([image_size[0] / 2, image_size[1] * 0.75, 1.0])
        depth = homography[2] @ np.linalg.solve(homography, centre)
        on_ground = np.linalg.solve(homography, centre)
        sign = np.sign(depth * on_ground[2]) or 1.0
        self._projection = matrix * sign
        self._to_image = homography * sign
        self._to_ground = np.linalg.inv(self._to_image)
        self.image_size = (int(image_size[0]), int(image_size[1]))
        self._fit = fit
        self._pose: Literal['known', 'recovered', 'assumed'] = 'known'

    @classmethod
    def from_homography(
        cls,
        image_from_ground: ArrayLike,
        image_size: tuple[int, int],
        fit: HomographyFit | None = None,
    ) -> Self:
        """
        Recover the vertical direction of a ground homography.

        Square pixels and a principal point at the image's centre are assumed; the focal length
        follows from the two ground axes being orthogonal and of equal length. Where it does not,
        as from above, a usual lens is assumed.

        Parameters
        ----------
        image_from_ground : (3, 3) array_like
            Homogeneous ground coordinates (m) to image (px).
        image_size : (int, int)
            Width and height, px.
        fit : HomographyFit, optional
            Where it is from.

        """
        homography = np.asarray(image_from_ground, np.float64)
        if homography.shape != (3, 3) or not np.isfinite(homography).all():
            raise ValueError(f'homography has shape {homography.shape}, expected finite (3, 3)')
        _check_regular(homography)
        width, height = image_size
        to_centre = np.array([[1.0, 0, -width / 2], [0, 1.0, -height / 2], [0, 0, 1.0]])
        found = _focal_length(*(to_centre @ homography)[:, :2].T)
        focal = found or float(max(width, height))
        intrinsics = np.diag([focal, focal, 1.0])
        pose = _pose(intrinsics, to_centre @ homography)
        mapping = cls(np.linalg.solve(to_centre, intrinsics @ pose), image_size, fit)
        mapping._pose = 'recovered' if found else 'assumed'
        return mapping

    @classmethod
    def from_points(
        cls,
        ground: ArrayLike,
        image: ArrayLike,
        image_size: tuple[int, int],
        click_noise_px: float = 0.5,
    ) -> Self:
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
        click_noise_px : float
            Standard deviation of a click along one axis, px.

        Raises
        ------
        ValueError
            If there are fewer than four points or all lie on a line.

        """
        places = points_of(ground)
        origin = local_origin(places)
        fit = fit_homography(places - origin, points_of(image), click_noise_px)
        return cls.from_homography(fit.matrix @ fit.frame, image_size, fit).moved(origin)

    @property
    def image_from_world(self) -> Floats:
        """Return the (3, 4) projection."""
        return _moved(self._projection, self.origin)

    @property
    def image_from_ground_homography(self) -> Floats:
        """Return the (3, 3) homography from the ground, m, to pixels."""
        return self.image_from_world[:, [0, 1, 3]]

    @property
    def ground_from_image_homography(self) -> Floats:
        """Return the (3, 3) homography from pixels to the ground, m."""
        matrix = self._to_ground.copy()
        matrix[:2] += np.outer(self.origin, matrix[2])
        return matrix

    @property
    def camera_position(self) -> Floats:
        """Return where the camera is, (3,) m."""
        return self._stated(self._place)

    @cached_property
    def _place(self) -> Floats:
        place: Floats = -np.linalg.solve(self._projection[:, :3], self._projection[:, 3])
        return place

    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN beyond the horizon."""
        return _projected(self._to_ground, points_of(pixel)) + self.origin

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
        points = self._local(position)
        if not np.any(height):
            return _projected(self._to_image, points)
        heights = np.broadcast_to(np.asarray(height, np.float64), len(points))
        world = np.column_stack([points, heights, np.ones(len(points))])
        image = world @ self._projection.T
        ahead = image[:, 2:] > 0
        return np.where(ahead, image[:, :2] / np.where(ahead, image[:, 2:], 1), np.nan)

    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""
        return _derivatives(self._to_image, self._local(position))

    def height_doubt(self, height: float) -> float:
        """
        Return how well the pose tells how many rows a height, m, spans: relative deviation.

        Of a pose that a homography leaves open: by how much `usual_height_px` changes if four
        points, as far apart as the image shows ground, lie `DOUBT` of the image's width off along
        each axis. Some percent up to 60 degrees of tilt; from straight above nothing is known.
        """
        if self._pose != 'recovered':
            return 0.0 if self._pose == 'known' else np.inf
        columns, rows = self.image_size
        shown = _projected(self._to_image, self.visible_ground() - self.origin)
        top = np.nanquantile(shown[:, 1], 0.25)
        corners = np.array([[0, top], [columns, top], [0, rows - 1], [columns, rows - 1]])
        ground = _projected(self._to_ground, corners)
        if not np.isfinite(ground).all():
            return np.inf
        usual_px, variance = self.usual_height_px(height), 0.0
        for index in np.ndindex(corners.shape):
            moved = corners.copy()
            moved[index] += DOUBT * columns
            other = self.from_homography(start_homography(ground, moved), self.image_size)
            variance += (other.usual_height_px(height) / usual_px - 1.0) ** 2
        return float(np.sqrt(variance)) if np.isfinite(variance) else np.inf

    def is_extrapolated(self, pixel: ArrayLike) -> Mask:
        """Tell which (n, 2) pixels lie beyond the points that the homography was fitted to."""
        if self._fit is None:
            return super().is_extrapolated(pixel)
        return doubts(self._fit.hull, points_of(pixel)) > 0

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², that the fit to points adds at positions, m."""
        if self._fit is None:
            return super().calibration_covariance(position)
        fit = self._fit
        in_frame = self._local(position) * fit.frame[0, 0] + fit.frame[:2, 2]
        image = _uncertain(fit.matrix, fit.terms, fit.hull, fit.misfit_px2, in_frame)
        return propagated(self.image_jacobian(position), image)


def inverted(ground_from_image: Floats) -> Floats:
    """Return the inverse of a homography to the ground, computed near what it shows."""
    near, depth = ground_from_image.copy(), ground_from_image[2]
    origin = local_origin(near[:2] @ depth / (depth @ depth)) if depth.any() else np.zeros(2)
    near[:2] -= np.outer(origin, depth)
    inverse = np.asarray(np.linalg.inv(near), np.float64)
    inverse[:, 2] -= inverse[:, :2] @ origin
    return inverse


def _check_regular(homography: Floats) -> None:
    """Refuse a homography that is singular, wherever its origin is."""
    flat, deep = homography[:, :2], homography[:, 2]
    beyond = deep - flat @ np.linalg.lstsq(flat, deep, rcond=None)[0]
    off = np.linalg.norm(beyond) <= SINGULAR * np.linalg.norm(deep)
    if off or np.linalg.matrix_rank(flat) < 2:
        raise ValueError('the ground plane projects to a line: the homography is singular')


def _near_camera(projection: Floats) -> Floats:
    """Return the origin, (2,) m, near the camera of a projection; zero if it has none."""
    upper = projection[:, :3]
    if np.linalg.matrix_rank(upper) < 3:
        return np.zeros(2)
    return local_origin(-np.linalg.solve(upper, projection[:, 3])[:2])


def _moved(projection: Floats, by: Floats) -> Floats:
    """Return the projection where all positions on the ground are greater by (2,) m."""
    moved = projection.copy()
    moved[:, 3] -= moved[:, :2] @ by
    return moved


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


@inner
def _reach(corners: Floats) -> float:
    """Return the root mean square distance of corners, (n, 2), from their middle."""
    x = y = square = 0.0
    for index in range(len(corners)):
        x += corners[index, 0]
        y += corners[index, 1]
    x, y = x / len(corners), y / len(corners)
    for index in range(len(corners)):
        square += (corners[index, 0] - x) ** 2
        square += (corners[index, 1] - y) ** 2
    return float(np.sqrt(square / len(corners)))


@compiled(types.f8[:, :, ::1](FLOATS_2D, FLOATS_2D, FLOATS_2D, types.f8, FLOATS_2D))
def _uncertain(
    matrix: Floats, terms: Floats, hull: Floats, misfit: float, places: Floats
) -> Floats:
    """Return covariances, px², of a fitted homography's pixels, more outside its points."""
    image, reach = np.zeros((len(places), 2, 2)), _reach(hull)
    for index in range(len(places)):
        a, b = places[index]
        depth = matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2]
        if not depth > 0.0:
            continue
        add_spread(matrix, terms, a, b, image[index])
        column = (matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2]) / depth
        row = (matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2]) / depth
        away = distance_squared(hull, column, row)
        variance = misfit * (1.0 + GROWTH * np.sqrt(away) / reach) ** 2 + doubt(hull, column, row)
        image[index, 0, 0] += variance
        image[index, 1, 1] += variance
    return image


def _pose(intrinsics: Floats, homography: Floats) -> Floats:
    """Return the (3, 4) pose above the ground of a camera with a homography, both (3, 3)."""
    rotated = np.linalg.solve(intrinsics, homography)
    scale = np.sqrt(np.linalg.norm(rotated[:, 0]) * np.linalg.norm(rotated[:, 1]))
    rotated = rotated / scale
    camera_height = -np.cross(rotated[:, 0], rotated[:, 1]) @ rotated[:, 2]
    if camera_height < 0:
        rotated = -rotated
    vertical = np.cross(rotated[:, 0], rotated[:, 1])
    return np.column_stack([rotated[:, 0], rotated[:, 1], vertical, rotated[:, 2]])


def _focal_length(first: Floats, second: Floats) -> float | None:
    """Return the focal length, px, for which two homography columns are orthonormal, if any."""
    flat_dot, flat_difference = (
        first[:2] @ second[:2],
        first[:2] @ first[:2] - second[:2] @ second[:2],
    )
    deep_dot, deep_difference = first[2] * second[2], first[2] ** 2 - second[2] ** 2
    design = np.array([flat_dot, flat_difference])
    target = -np.array([deep_dot, deep_difference])
    inverse_square = float(design @ target / (design @ design)) if design.any() else 0.0
    return float(np.sqrt(1 / inverse_square)) if inverse_square > 0 else None
