"""A camera from clicked points as least squares: their misses, and what lenses usually are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from mctrack_ros.ground.camera.pinhole import PARAMETERS, UNKNOWNS, Camera, CameraMapping

Floats = NDArray[np.float64]
ROBUST_SCALE = 2.5
"""Miss of a click from which it counts for less and less, in noises."""
FAR = 4e3
"""What a point that the camera cannot see misses by, in noises."""
FOCAL_SPREAD = 1.0
CENTRE_SPREAD = 0.02
LENS_SPREAD = {
    'k1': 1.0, 'aspect ratio': 0.007, 'k2': 0.05, 'p1': 0.001, 'p2': 0.001, 'k3': 0.02,
}  # fmt: skip
MOST_STEPS = 200
ODD = 5.0
"""Deviations from what lenses usually are from which a camera is unusual."""
_ROTATION = slice(2, 5)
_DISTORTION = [PARAMETERS.index(name) for name in ('k1', 'k2', 'p1', 'p2', 'k3')]
_CENTRE = [PARAMETERS.index(f'principal point {axis}') for axis in 'xy']
_ASPECT = PARAMETERS.index('aspect ratio')
_LENS = [PARAMETERS.index(name) for name in LENS_SPREAD]


class LensPrior:
    """
    Priors of lens parameters, for what the points leave open: normal distributions.

    The focal length's logarithm deviates by 1 from that of the image's longer side, the
    principal point by 2 % of that side from the image's middle, the aspect ratio by 0.007 from
    1, and the terms of the lens from 0 by 1 (k1), 0.05 (k2), 0.02 (k3) and 0.001 (p1, p2). A
    camera that looks straight down sees the ground the same from twice as high with twice the
    focal length; this decides.

    Parameters
    ----------
    image_size : (int, int)
        Width and height of the image, px.

    """

    def __init__(self, image_size: tuple[int, int]) -> None:
        self.image_size = image_size
        self.known = [0, *_CENTRE, *_LENS]
        self.middle = np.zeros(UNKNOWNS)
        self.middle[0] = max(image_size)
        self.middle[_CENTRE] = np.divide(image_size, 2)
        self.middle[_ASPECT] = 1.0
        self.spread = np.ones(UNKNOWNS)
        self.spread[0] = FOCAL_SPREAD
        self.spread[_CENTRE] = CENTRE_SPREAD * max(image_size)
        self.spread[_LENS] = list(LENS_SPREAD.values())

    def deviations(self, values: Floats) -> Floats:
        """Return how far a camera's `known` parameters are from usual, (9,) deviations."""
        away = values - self.middle
        away[0] = np.log(values[0] / self.middle[0])
        deviations: Floats = (away / self.spread)[self.known]
        return deviations

    def oddity(self, values: Floats) -> str:
        """Return what is unusual about a camera's lens, the worst alone; empty: nothing."""
        away = np.abs(self.deviations(values))
        worst = self.known[int(away.argmax())]
        if away.max() <= ODD:
            return ''
        usual = f'usual: {self.middle[worst]:.3g}'
        return f'its {PARAMETERS[worst]} would be {values[worst]:.3g} ({usual})'

    def slopes(self, focal_px: float) -> Floats:
        """Return the (9, 15) derivatives of the same by all parameters, at a focal length."""
        slopes = np.diag(1 / self.spread)
        slopes[0, 0] /= focal_px
        known: Floats = slopes[self.known]
        return known


class CameraProblem:
    """
    Misses and their derivatives by `PARAMETERS`, in noises, of one start.

    Parameters
    ----------
    start : Camera
        Where to begin; the rotation is a turn from it.
    ground, image : (n, 2) arrays
        The points, m, and their clicks, px.
    prior : LensPrior
        Of the images.
    noise_px : (n,) array
        Standard deviations of the clicks along one axis, px.

    """

    def __init__(
        self, start: Camera, ground: Floats, image: Floats, prior: LensPrior, noise_px: Floats
    ) -> None:
        self._start, self._ground, self._image, self._prior = start, ground, image, prior
        self._noise_px = noise_px[:, None]
        self._last: tuple[Floats, CameraMapping] | None = None
        across, down, x, y = start.intrinsics
        k1, k2, p1, p2, k3 = start.distortion
        self.first = np.array(
            [across, k1, 0, 0, 0, *start.translation, x, y, down / across, k2, p1, p2, k3]
        )

    @property
    def clicks(self) -> int:
        """How many there are."""
        return len(self._image)

    def camera(self, values: Floats) -> Camera:
        """Return the camera of (15,) parameters."""
        turn = Rotation.from_rotvec(values[_ROTATION]).as_matrix()
        focal, aspect = values[0], values[_ASPECT]
        return Camera(
            np.array([focal, focal * aspect, *values[_CENTRE]]),
            values[_DISTORTION],
            turn @ self._start.rotation,
            values[5:8],
        )

    def misses(self, values: Floats) -> Floats:
        """Return the misses along both axes, and the prior's deviations, (2n + 9,)."""
        values = _possible(values)
        seen = self._mapping(values).unfolded(self._ground)
        missed = np.where(np.isfinite(seen), (seen - self._image) / self._noise_px, FAR)
        return np.concatenate([missed.ravel(), self._prior.deviations(values)])

    def derivatives(self, values: Floats) -> Floats:
        """Return the (2n + 9, 15) derivatives of the misses by the parameters."""
        values = _possible(values)
        slopes = self._mapping(values).parameter_jacobian(self._ground)
        slopes /= self._noise_px[..., None]
        slopes[:, :, _ROTATION] = slopes[:, :, _ROTATION] @ _turned(values[_ROTATION])
        slopes = np.where(np.isfinite(slopes), slopes, 0.0).reshape(-1, UNKNOWNS)
        return np.concatenate([slopes, self._prior.slopes(values[0])])

    def _mapping(self, values: Floats) -> CameraMapping:
        """Return the camera's mapping; misses and derivatives are asked one after the other."""
        if self._last is None or not np.array_equal(self._last[0], values):
            mapping = CameraMapping(self.camera(values), self._prior.image_size)
            self._last = values, mapping
        return self._last[1]

    def solved(self, is_robust: bool) -> tuple[Camera, float]:
        """Return the camera at the minimum and its cost; robust: soft L1 of clicks."""
        loss = self._robust if is_robust else 'linear'
        result = least_squares(
            self.misses, self.first, self.derivatives, loss=loss, x_scale='jac',
            max_nfev=MOST_STEPS,
        )  # fmt: skip
        return self.camera(_possible(result.x)), float(result.cost)

    def _robust(self, squared: Floats) -> Floats:
        """Return soft L1 of the clicks' squared misses, the prior's as they are, and slopes."""
        clicks = 2 * len(self._ground)
        root = np.sqrt(1 + squared[:clicks] / ROBUST_SCALE**2)
        values = np.stack([squared, np.ones_like(squared), np.zeros_like(squared)])
        values[0, :clicks] = 2 * ROBUST_SCALE**2 * (root - 1)
        values[1, :clicks] = 1 / root
        values[2, :clicks] = -1 / (2 * ROBUST_SCALE**2 * root**3)
        return values

    def covariance(self) -> tuple[Floats, float]:
        """Return the (15, 15) covariance of the start, and how many parameters points fix."""
        slopes = self.derivatives(self.first)
        information = slopes.T @ slopes
        scale = 1 / np.sqrt(np.diag(information))  # the units are balanced before it is inverted
        covariance = np.linalg.inv(information * scale[:, None] * scale) * scale[:, None] * scale
        symmetric: Floats = (covariance + covariance.T) / 2
        prior = self._prior.slopes(self.first[0])
        assumed = np.einsum('kp,pq,kq->', prior, symmetric, prior)
        return symmetric, float(UNKNOWNS - assumed)


def _possible(values: Floats) -> Floats:
    """Return parameters whose focal lengths are above 0."""
    values = values.copy()
    values[0], values[_ASPECT] = max(values[0], 1.0), max(values[_ASPECT], 0.1)
    return values


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
