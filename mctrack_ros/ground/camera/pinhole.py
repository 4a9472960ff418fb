"""A calibrated camera over the ground plane: pinhole with lens distortion, as OpenCV has it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, FLOATS_3D, compiled, inner
from mctrack_ros.ground.camera.distortion import (
    DERIVED,
    SURE,
    distort,
    packed_lens,
    pole_radius,
    turning_radius,
    undistort,
)
from mctrack_ros.ground.mapping import GroundMapping, Mask, points_of, solve_spread
from mctrack_ros.ground.support import doubt, doubts, hull_of

Floats = NDArray[np.float64]
PARAMETERS = (
    'focal length', 'k1', 'rotation x', 'rotation y', 'rotation z', 'x', 'y', 'z',
    'principal point x', 'principal point y', 'aspect ratio', 'k2', 'p1', 'p2', 'k3',
)  # fmt: skip
"""What of a camera can be uncertain: px, none, rad about the camera's axes, m along them; px, and
none for the rest. The focal length is that across; the aspect ratio is that down over it."""
UNKNOWNS = len(PARAMETERS)
DERIVATIVES = 2 + UNKNOWNS
EDGE_SHARE = 0.97
"""How near to where a lens model folds over its image is used, in tangents off the axis."""
FARTHEST_EDGE = 100.0
LARGEST_UNSURE_M = 0.01
"""How far off the digits of its rotation may leave a camera: its place is turned with them."""
EDGE_POINTS = 720  # directions in which the edge is sought, two a degree
_POINTS = types.f8[:, ::1]
_MATRICES = types.f8[:, :, ::1]


@dataclass(frozen=True, eq=False)
class Camera:
    """
    Where a camera is and what its lens does.

    Attributes
    ----------
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    distortion : (5,) or (8,) array
        k1, k2, p1, p2, k3 (, k4, k5, k6) of OpenCV.
    rotation : (3, 3) array
        From world to camera axes (right, down, forward).
    translation : (3,) array
        The world's origin in camera axes, m.
    covariance : (15, 15) array
        Of `PARAMETERS`, small changes: the rotation is followed by one about the camera's axes.
        Zero where the calibration has none.

    """

    intrinsics: Floats
    distortion: Floats
    rotation: Floats
    translation: Floats
    covariance: Floats = field(default_factory=lambda: np.zeros((UNKNOWNS, UNKNOWNS)))

    def __post_init__(self) -> None:
        """Refuse what is no camera."""
        shapes = {
            'intrinsics': (4,), 'distortion': (5,), 'rotation': (3, 3), 'translation': (3,),
            'covariance': (UNKNOWNS, UNKNOWNS),
        }  # fmt: skip
        for name, shape in shapes.items():
            array = np.ascontiguousarray(getattr(self, name), np.float64)
            fits = array.shape == shape or (name == 'distortion' and array.shape == (8,))
            if not fits or not np.isfinite(array).all():
                raise ValueError(f'{name} has shape {array.shape}, expected finite {shape}')
            object.__setattr__(self, name, array)
        if (self.intrinsics[:2] <= 0).any():
            raise ValueError(f'focal lengths are {self.intrinsics[:2]} px, expected above 0')
        skewed = np.abs(self.rotation @ self.rotation.T - np.eye(3))
        if (skewed > 1e-6 + 1e-5 * np.eye(3)).any():
            raise ValueError('rotation is not orthonormal')
        unsure_m = float(skewed.max()) * float(np.linalg.norm(self.translation))
        if unsure_m > LARGEST_UNSURE_M:
            raise ValueError(
                f'the rotation has too few digits for a camera so far from the origin: its place '
                f'is unsure by {unsure_m:.2g} m; state the pose about a point near by'
            )
        if np.linalg.det(self.rotation) < 0:
            raise ValueError('rotation is a reflection: is the sign of one axis wrong?')

    @property
    def position(self) -> Floats:
        """Where it stands, (3,) m."""
        place: Floats = -self.rotation.T @ self.translation
        return place

    def moved(self, by: Floats) -> Camera:
        """Return the camera where all positions on the ground are greater by (2,) m."""
        carried = _carried(self.rotation, by)
        return replace(
            self,
            translation=self.translation - self.rotation[:, :2] @ by,
            covariance=carried @ self.covariance @ carried.T,
        )

    @property
    def image_from_world(self) -> Floats:
        """The (3, 4) projection without distortion."""
        across, down, x, y = self.intrinsics
        matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]])
        projection: Floats = matrix @ np.column_stack([self.rotation, self.translation])
        return projection


def _carried(rotation: Floats, by: Floats) -> Floats:
    """Return the (15, 15) derivatives of a moved camera's `PARAMETERS` by those before."""
    x, y, z = rotation[:, :2] @ by
    turn, place = PARAMETERS.index('rotation x'), PARAMETERS.index('x')
    carried = np.eye(len(PARAMETERS))
    carried[place : place + 3, turn : turn + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return carried


class CameraMapping(GroundMapping):
    """
    Image <-> ground plane z = 0 through a `Camera`, its uncertainty carried along.

    Parameters
    ----------
    camera : Camera
        The camera.
    image_size : (int, int)
        Width and height of its images, px.
    support : (n, 2) array, optional
        Pixels that it was calibrated by: beyond their convex hull it is extrapolated.

    Raises
    ------
    ValueError
        If it stands on the ground plane.

    """

    def __init__(
        self, camera: Camera, image_size: tuple[int, int], support: Floats | None = None
    ) -> None:
        if abs(camera.position[2]) < 1e-6:
            raise ValueError('the camera stands on the ground plane: it sees it as a line')
        self._camera = camera
        self.image_size = (int(image_size[0]), int(image_size[1]))
        self._hull = hull_of(support)
        self._lens = packed_lens(camera.intrinsics, camera.distortion)
        self._pose = np.ascontiguousarray(np.column_stack([camera.rotation, camera.translation]))

    @property
    def camera(self) -> Camera:
        """The camera."""
        return self._camera.moved(self.origin) if self.origin.any() else self._camera

    @property
    def camera_position(self) -> Floats:
        """Where the camera stands, (3,) m."""
        return self._stated(self._camera.position)

    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN beyond the horizon."""
        return _on_ground(self._lens, self._pose, points_of(pixel)) + self.origin

    def image_from_ground(self, position: ArrayLike, height: ArrayLike = 0.0) -> Floats:
        """Return the (n, 2) pixels of (n, 2) ground positions, m; NaN where it cannot see."""
        heights = np.ascontiguousarray(height, np.float64).reshape(-1)
        return _in_image(self._lens, self._pose, self._local(position), heights)

    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""
        return _slopes(self._lens, self._pose, self._local(position))

    def lens_edge(self) -> Floats:
        """Return (n, 2) pixels around what the lens model has one direction for; none: all."""
        lens = self._camera.distortion
        radius = min(EDGE_SHARE * turning_radius(lens), SURE * pole_radius(lens))
        if radius > FARTHEST_EDGE:
            return super().lens_edge()
        angle = np.linspace(0, 2 * np.pi, EDGE_POINTS, endpoint=False)
        direction = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        ahead = np.column_stack([np.eye(3), [0.0, 0.0, 1.0]])
        return _in_image(self._lens, ahead, direction, np.zeros(1))

    def is_extrapolated(self, pixel: ArrayLike) -> Mask:
        """Tell which (n, 2) pixels lie beyond those that the camera was calibrated by."""
        return doubts(self._hull, points_of(pixel)) > 0

    def unfolded(self, position: ArrayLike) -> Floats:
        """Return the (n, 2) pixels of positions, m, also where the lens model folds back."""
        lens = np.append(self._lens[:-1], np.inf)
        return _in_image(lens, self._pose, self._local(position), np.zeros(1))

    def parameter_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 15) derivatives of the pixels of positions, m, by `PARAMETERS`."""
        derivatives = _derivatives(self._lens, self._pose, self._local(position))[:, :, 2:]
        if not self.origin.any():
            return derivatives
        moved: Floats = derivatives @ _carried(self._camera.rotation, -self.origin)
        return moved

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², that the calibration adds at positions, m."""
        return self._covariance(self._local(position), np.zeros((1, 2, 2)))

    def ground_covariance(self, position: ArrayLike, pixel_covariance: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², of positions, m, seen so well, px²."""
        return self._covariance(self._local(position), pixel_covariance)

    def _covariance(self, position: Floats, pixel_covariance: ArrayLike) -> Floats:
        noise = np.asarray(pixel_covariance, np.float64).reshape(-1, 2, 2)
        return _spread(
            self._lens, self._pose, self._camera.covariance, self._hull, position,
            np.ascontiguousarray(noise),
        )  # fmt: skip


@compiled(_POINTS(FLOATS_1D, FLOATS_2D, FLOATS_2D))
def _on_ground(lens: Floats, pose: Floats, pixel: Floats) -> Floats:
    position = np.full((len(pixel), 2), np.nan)
    work = np.empty(DERIVED)
    for index in range(len(pixel)):
        x, y = undistort(lens, pixel[index, 0], pixel[index, 1], work)
        # the ray meets the ground where x and y of the plane's homography are solved for
        a, b = pose[0, 0] - x * pose[2, 0], pose[0, 1] - x * pose[2, 1]
        c, d = pose[1, 0] - y * pose[2, 0], pose[1, 1] - y * pose[2, 1]
        e, f = x * pose[2, 3] - pose[0, 3], y * pose[2, 3] - pose[1, 3]
        scale = a * d - b * c
        if scale == 0.0:
            continue
        ground_x, ground_y = (d * e - b * f) / scale, (a * f - c * e) / scale
        if pose[2, 0] * ground_x + pose[2, 1] * ground_y + pose[2, 3] > 0.0:
            position[index, 0], position[index, 1] = ground_x, ground_y
    return position


@compiled(_POINTS(FLOATS_1D, FLOATS_2D, FLOATS_2D, FLOATS_1D))
def _in_image(lens: Floats, pose: Floats, position: Floats, height: Floats) -> Floats:
    """Return the pixels of positions at heights, one for all or one each."""
    pixel = np.full((len(position), 2), np.nan)
    work, axes = np.empty(DERIVED), np.empty(3)
    for index in range(len(position)):
        above = height[index if len(height) > 1 else 0]
        for axis in range(3):
            axes[axis] = pose[axis, 3]
            axes[axis] += pose[axis, 0] * position[index, 0]
            axes[axis] += pose[axis, 1] * position[index, 1]
            axes[axis] += pose[axis, 2] * above
        if axes[2] > 0.0:
            x, y = axes[0] / axes[2], axes[1] / axes[2]
            if x * x + y * y <= lens[12]:
                distort(lens, x, y, work)
                pixel[index, 0] = lens[0] * work[0] + lens[2]
                pixel[index, 1] = lens[1] * work[1] + lens[3]
    return pixel


@inner
def _derive(
    lens: Floats, pose: Floats, x: float, y: float, work: Floats, by_axes: Floats, out: Floats
) -> None:
    """Write the (2, 17) derivatives of a ground position's pixel: by it, by `PARAMETERS`."""
    turned_x = pose[0, 0] * x + pose[0, 1] * y
    turned_y = pose[1, 0] * x + pose[1, 1] * y
    turned_z = pose[2, 0] * x + pose[2, 1] * y
    depth = turned_z + pose[2, 3]
    if not depth > 0.0:
        out[:] = np.nan
        return
    across, down = (turned_x + pose[0, 3]) / depth, (turned_y + pose[1, 3]) / depth
    distort(lens, across, down, work)
    square = across * across + down * down
    for row in range(2):
        focal = lens[row]
        left, right = work[2 + 2 * row], work[3 + 2 * row]
        by_axes[0] = focal * left / depth
        by_axes[1] = focal * right / depth
        by_axes[2] = -focal * (left * across + right * down) / depth
        for axis in range(2):
            out[row, axis] = (
                by_axes[0] * pose[0, axis] + by_axes[1] * pose[1, axis]
                + by_axes[2] * pose[2, axis]
            )  # fmt: skip
        direction = across if row == 0 else down
        out[row, 2] = work[row] * focal / lens[0]
        radial = focal * direction * square * work[6]
        out[row, 3] = radial
        out[row, 4] = by_axes[2] * turned_y - by_axes[1] * turned_z
        out[row, 5] = by_axes[0] * turned_z - by_axes[2] * turned_x
        out[row, 6] = by_axes[1] * turned_x - by_axes[0] * turned_y
        out[row, 7], out[row, 8], out[row, 9] = by_axes[0], by_axes[1], by_axes[2]
        out[row, 10], out[row, 11] = 1.0 - row, row
        out[row, 12] = row * lens[0] * work[1]
        out[row, 13], out[row, 16] = radial * square, radial * square * square
        both, straight = (
            2.0 * focal * across * down,
            focal * (square + 2.0 * direction * direction),
        )
        out[row, 14] = straight if row else both
        out[row, 15] = both if row else straight


@inner
def _is_folded(lens: Floats, pose: Floats, x: float, y: float) -> bool:
    """Tell whether a ground position lies beyond the lens's edge, where its model folds back."""
    across = pose[0, 0] * x + pose[0, 1] * y + pose[0, 3]
    down = pose[1, 0] * x + pose[1, 1] * y + pose[1, 3]
    depth = pose[2, 0] * x + pose[2, 1] * y + pose[2, 3]
    return bool(across * across + down * down > lens[12] * depth * depth)


@compiled(_MATRICES(FLOATS_1D, FLOATS_2D, FLOATS_2D))
def _derivatives(lens: Floats, pose: Floats, position: Floats) -> Floats:
    derivatives = np.empty((len(position), 2, DERIVATIVES))
    work, by_axes = np.empty(DERIVED), np.empty(3)
    for index in range(len(position)):
        x, y = position[index]
        _derive(lens, pose, x, y, work, by_axes, derivatives[index])
    return derivatives


@compiled(_MATRICES(FLOATS_1D, FLOATS_2D, FLOATS_2D))
def _slopes(lens: Floats, pose: Floats, position: Floats) -> Floats:
    """Return the (n, 2, 2) derivatives of pixels by positions; NaN where it cannot see."""
    slopes, jacobian = np.empty((len(position), 2, 2)), np.empty((2, DERIVATIVES))
    work, by_axes = np.empty(DERIVED), np.empty(3)
    for index in range(len(position)):
        x, y = position[index]
        _derive(lens, pose, x, y, work, by_axes, jacobian)
        folded = _is_folded(lens, pose, x, y)
        for row in range(2):
            for axis in range(2):
                slopes[index, row, axis] = np.nan if folded else jacobian[row, axis]
    return slopes


@compiled(_MATRICES(FLOATS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, FLOATS_2D, FLOATS_3D))
def _spread(
    lens: Floats, pose: Floats, calibration: Floats, hull: Floats, position: Floats, noise: Floats
) -> Floats:
    """Return ground covariances: of pixels, one for all or one each, of the camera, outside."""
    spread = np.empty((len(position), 2, 2))
    work, by_axes, jacobian = np.zeros(DERIVED), np.empty(3), np.empty((2, DERIVATIVES))
    known, image = False, np.empty((2, 2))
    for value in calibration.flat:
        known |= value != 0.0
    for index in range(len(position)):
        x, y = position[index]
        _derive(lens, pose, x, y, work, by_axes, jacobian)
        if _is_folded(lens, pose, x, y):
            jacobian[:] = np.nan
        for row in range(2):
            for column in range(2):
                image[row, column] = noise[index if len(noise) > 1 else 0, row, column]
        if len(hull) > 0:
            across, down = lens[0] * work[0] + lens[2], lens[1] * work[1] + lens[3]
            variance = doubt(hull, across, down)
            image[0, 0] += variance
            image[1, 1] += variance
        if known:
            for i in range(UNKNOWNS):
                across, down = 0.0, 0.0
                for j in range(UNKNOWNS):
                    across += calibration[i, j] * jacobian[0, 2 + j]
                    down += calibration[i, j] * jacobian[1, 2 + j]
                image[0, 0] += jacobian[0, 2 + i] * across
                image[0, 1] += jacobian[0, 2 + i] * down
                image[1, 0] += jacobian[1, 2 + i] * across
                image[1, 1] += jacobian[1, 2 + i] * down
        solve_spread(
            jacobian[0, 0], jacobian[0, 1], jacobian[1, 0], jacobian[1, 1], image, spread[index]
        )
    return spread
