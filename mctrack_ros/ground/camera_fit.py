"""A camera fitted to clicked points, and what the points say about it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.special import gammaincinv

from mctrack_ros.ground.camera import PARAMETERS, Camera, CameraMapping
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.homography_fit import start_homography
from mctrack_ros.ground.mapping import points_of
from mctrack_ros.ground.origin import local_origin
from mctrack_ros.ground.projective import ProjectiveMapping

Floats = NDArray[np.float64]
CLICK_NOISE_PX = 0.5
ROBUST_SCALE = 2.5
FEWEST = len(PARAMETERS) // 2 + 2
"""Points without which nothing is left to check the fit by: two more than it has unknowns for."""
FOCAL_SPREAD, K1_SPREAD = 0.7, 0.5
"""Spread of lenses: of the focal length's logarithm about the picture's longer side, and of k1.
A camera that looks straight down sees the ground the same from twice as high with twice the focal
length; this decides."""
WILD = 3.5
"""Distance of a click from where the camera sees its point from which it is wild, in noises."""
BELIEVED = 0.99
"""Probability up to which larger misses than the stated noise makes are taken for chance."""
NEAREST = 20.0
"""Standard deviation of the points in the picture below which they say too little, in noises."""
LARGEST_ERROR = 0.05
"""Predicted error from which points say too little, as a share of the area that they span."""
FOCAL_STARTS = (0.5, 0.8, 1.3, 2.0, 4.0)
TRIED = 2
SWAPPED = 'no camera sees the points so: are two of them swapped?'


class FitError(CalibrationError):
    """Points to which no camera can be fitted; says why."""


@dataclass(frozen=True, eq=False, slots=True)
class CameraFit:
    """
    A camera and how well it fits its points.

    Attributes
    ----------
    mapping : CameraMapping
        The camera, its covariance included.
    ground : (n, 2) array
        The points, m.
    image : (n, 2) array
        Where they were clicked, px.
    residual : (n, 2) array
        Clicked minus where the camera sees them, px.
    noise_px : float
        Standard deviation of a click along one axis, px: as stated or, if clearly larger, as
        found.

    """

    mapping: CameraMapping
    ground: Floats
    image: Floats
    residual: Floats
    noise_px: float

    @property
    def rms_px(self) -> float:
        """Root mean square distance of the clicks from the camera's, px."""
        return float(np.sqrt((self.residual**2).sum(axis=1).mean()))


def fit_camera(
    ground: ArrayLike,
    image: ArrayLike,
    image_size: tuple[int, int],
    click_noise_px: float = CLICK_NOISE_PX,
    start: Camera | None = None,
) -> CameraFit:
    """
    Fit a pinhole camera with radial distortion to points on the ground.

    One focal length and k1 are estimated, with where the camera is; the principal point is taken
    to be the picture's centre and pixels to be square. A click that is far off counts for little
    (soft L1 beyond 2.5 times the noise).

    Parameters
    ----------
    ground : (n, 2) array_like
        The points, m.
    image : (n, 2) array_like
        Their pixels.
    image_size : (int, int)
        Width and height of the picture, px.
    click_noise_px : float
        Standard deviation of a click along one axis, px.
    start : Camera, optional
        A camera near by, to begin with: one fitted to nearly the same points. Unless given,
        several are tried.

    Raises
    ------
    FitError
        If the points are too few, lie on a line, are not finite, or say too little.

    """
    places, image = points_of(ground), points_of(image)
    origin = local_origin(places)
    ground = places - origin
    _check(ground, image, click_noise_px)
    starts = _starts(ground, image, image_size) if start is None else [start.moved(-origin)]
    camera = _solved(starts, ground, image, image_size, click_noise_px)
    fitted = CameraMapping(camera, image_size)
    residual = image - fitted.image_from_ground(ground)
    farthest = float(np.abs(image - np.divide(image_size, 2)).max())
    if not np.abs(residual).max() <= farthest:
        raise FitError(SWAPPED)
    weight = _weights(residual, click_noise_px)
    noise_px = _noise(residual, weight, click_noise_px)
    covariance = _covariance(fitted, ground, weight / noise_px**2)
    mapping = CameraMapping(replace(camera, covariance=covariance), image_size, image)
    _check_informative(mapping, ground)
    return CameraFit(mapping.moved(origin), places, image, residual, noise_px)


def _solved(
    starts: list[Camera],
    ground: Floats,
    image: Floats,
    image_size: tuple[int, int],
    noise_px: float,
) -> Camera:
    """Return the camera that misses the points least, from the starts that miss least."""
    problems = [
        _Problem(start, ground, image, image_size, ROBUST_SCALE * noise_px) for start in starts
    ]
    if not problems:
        raise FitError(SWAPPED)
    problems.sort(key=lambda problem: float(np.abs(problem.misses(problem.first)).sum()))
    camera, _ = min((each.solved() for each in problems[:TRIED]), key=lambda found: found[1])
    return camera


def _check(ground: Floats, image: Floats, noise_px: float) -> None:
    if len(ground) != len(image):
        raise FitError(f'{len(ground)} ground points and {len(image)} pixels')
    if not (np.isfinite(ground).all() and np.isfinite(image).all()):
        raise FitError('a point is not finite')
    if len(np.unique(ground, axis=0)) != len(ground):
        raise FitError('two points lie at the same place on the ground')
    if len(ground) < FEWEST:
        raise FitError(
            f'{len(ground)} points are under-determined: a camera has {len(PARAMETERS)} unknowns, '
            f'expected at least {FEWEST} points'
        )
    for name, points in (('on the ground', ground), ('in the picture', image)):
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] < 1e-3 * spread[0]:
            raise FitError(f'the points lie on a line {name}: they fix no camera')
    deviation = spread[1] / np.sqrt(len(image))
    if deviation < NEAREST * noise_px:
        raise FitError(
            f'the points are under-determined: they deviate by {deviation:.1f} px alone in the '
            'picture; add points that are spread over it'
        )


def _check_informative(mapping: CameraMapping, ground: Floats) -> None:
    """Refuse a camera that its own points do not pin down."""
    covariance = mapping.calibration_covariance(ground)
    deviation = float(np.sqrt(np.trace(covariance, axis1=1, axis2=2).max()))
    extent = float(np.linalg.norm(np.ptp(ground, axis=0)))
    if not deviation <= LARGEST_ERROR * extent:
        raise FitError(
            f'the points are under-determined: the camera fitted to them is uncertain by '
            f'{deviation:.2g} m at its own points; add points that are spread over the picture'
        )


def _starts(ground: Floats, image: Floats, image_size: tuple[int, int]) -> list[Camera]:
    """Return cameras to begin with: one homography, read with several focal lengths."""
    try:
        start = start_homography(ground, image)
        mapping = ProjectiveMapping.from_homography(start, image_size)
    except ValueError:
        return []
    width, height = image_size
    homography = mapping.image_from_ground_homography
    starts = []
    for share in FOCAL_STARTS:
        focal = share * max(width, height)
        inverse = np.array(
            [[1 / focal, 0, -width / 2 / focal], [0, 1 / focal, -height / 2 / focal], [0, 0, 1]]
        )
        columns = inverse @ homography
        columns /= np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
        axes = np.column_stack([columns[:, :2], np.cross(columns[:, 0], columns[:, 1])])
        left, _, right = np.linalg.svd(axes)
        rotation = left @ right
        if np.linalg.det(rotation) < 0:
            continue
        intrinsics = np.array([focal, focal, width / 2, height / 2])
        starts.append(Camera(intrinsics, np.zeros(5), rotation, columns[:, 2]))
    return starts


class _Problem:
    """The robust least squares of one start: misses and their derivatives, by 8 unknowns."""

    def __init__(
        self,
        start: Camera,
        ground: Floats,
        image: Floats,
        image_size: tuple[int, int],
        scale_px: float,
    ) -> None:
        self._start, self._ground, self._image = start, ground, image
        self._size, self._scale_px = image_size, scale_px
        focal_k1 = [start.intrinsics[0], start.distortion[0]]
        self.first = np.concatenate([focal_k1, np.zeros(3), start.translation])

    def camera(self, values: Floats) -> Camera:
        turn = Rotation.from_rotvec(values[2:5]).as_matrix()
        focal = max(values[0], 1.0)
        return Camera(
            np.array([focal, focal, *self._start.intrinsics[2:]]),
            np.array([values[1], 0, 0, 0, 0]),
            turn @ self._start.rotation,
            values[5:],
        )

    def misses(self, values: Floats) -> Floats:
        seen = CameraMapping(self.camera(values), self._size).unfolded(self._ground)
        missed = np.where(np.isfinite(seen), (seen - self._image) / self._scale_px, FAR)
        focal, k1 = max(values[0], 1.0), values[1]
        odd = [np.log(focal / max(self._size)) / FOCAL_SPREAD, k1 / K1_SPREAD]
        return np.concatenate([missed.ravel(), np.divide(odd, ROBUST_SCALE)])

    def derivatives(self, values: Floats) -> Floats:
        mapping = CameraMapping(self.camera(values), self._size)
        slopes = mapping.parameter_jacobian(self._ground)
        slopes[:, :, 2:5] = slopes[:, :, 2:5] @ _turned(values[2:5])
        slopes = np.where(np.isfinite(slopes), slopes, 0.0).reshape(-1, 8) / self._scale_px
        odd = np.zeros((2, 8))
        odd[0, 0], odd[1, 1] = 1 / max(values[0], 1.0) / FOCAL_SPREAD, 1 / K1_SPREAD
        return np.concatenate([slopes, odd / ROBUST_SCALE])

    def solved(self) -> tuple[Camera, float]:
        """Return the camera at the minimum and its cost."""
        result = least_squares(
            self.misses, self.first, self.derivatives, loss='soft_l1', x_scale='jac'
        )
        return self.camera(result.x), float(result.cost)


def _turned(vector: Floats) -> Floats:
    """Return how a rotation vector's change turns what it has turned: the left Jacobian."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if angle < 1e-6:
        return np.eye(3) + cross / 2
    first, second = (1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    jacobian: Floats = np.eye(3) + first * cross + second * cross @ cross
    return jacobian


FAR = 1e4
"""What a point that the camera cannot see misses by, in robust scales."""


def _weights(residual: Floats, noise_px: float) -> Floats:
    """Return how much each point tells, (n,): all that it can, unless it is a wild click."""
    distance = np.linalg.norm(residual, axis=1) / (WILD * noise_px)
    weight: Floats = 1 / np.maximum(distance, 1.0) ** 2
    return weight


def _noise(residual: Floats, weight: Floats, stated_px: float) -> float:
    """Return the noise of a click along one axis, px: as stated, unless the misses belie it."""
    freedom = 2 * len(residual) - len(PARAMETERS)
    missed = float((weight[:, None] * residual**2).sum())
    usual = 2 * gammaincinv(freedom / 2, BELIEVED)  # so much at most, chi-squared
    if missed <= stated_px**2 * usual:
        return stated_px
    return float(np.sqrt(missed / freedom))


def _covariance(mapping: CameraMapping, ground: Floats, weight: Floats) -> Floats:
    """Return the (8, 8) covariance of a camera seen by points that weigh so much, 1/px²."""
    jacobian = mapping.parameter_jacobian(ground)
    information = np.einsum('n,nik,nil->kl', weight, jacobian, jacobian)
    information[0, 0] += 1 / (FOCAL_SPREAD * mapping.camera.intrinsics[0]) ** 2
    information[1, 1] += 1 / K1_SPREAD**2
    scale = 1 / np.sqrt(np.diag(information))  # the units are balanced before it is inverted
    covariance = np.linalg.inv(information * scale[:, None] * scale) * scale[:, None] * scale
    symmetric: Floats = (covariance + covariance.T) / 2
    return symmetric
