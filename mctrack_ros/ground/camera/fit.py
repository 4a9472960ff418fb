"""A camera fitted to clicked points, and what the points say about it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from mctrack_ros.ground.camera.fit_problem import CameraProblem, LensPrior
from mctrack_ros.ground.camera.pinhole import Camera, CameraMapping
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.homography.fit import start_homography
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import points_of

Floats = NDArray[np.float64]
CLICK_NOISE_PX = 0.5
FEWEST = 6
"""Points without which nothing is left to check the fit by: a homography takes four."""
WILD = 3.5
"""Distance of a click from where the camera sees its point from which it is wild, in noises."""
BELIEVED = 0.99
"""Probability up to which larger misses than the stated noise makes are taken for chance."""
NEAREST = 20.0
"""Standard deviation of the points in the image below which they say too little, in noises."""
LARGEST_ERROR = 0.05
"""Predicted error from which points say too little, as a share of the area that they span."""
MOST_FOLDED = 0.05
"""Share of the points, at the image's rim, from which a lens may lead no way back."""
FOCAL_STARTS = (0.5, 0.8, 1.3, 2.0, 4.0)  # of the image width: lenses from wide to tele
TRIED = 2  # best of these starts that are refined
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
    left_out : (n, 2) array
        Clicked minus where the other points put them, px, to first order.
    noise_px : float
        Standard deviation of a click along one axis, px: as stated or, if clearly larger, as
        found.
    oddity : str
        What no usual lens is like, for example a principal point far from the image's middle,
        which is what points of a cropped or scaled image give; empty: nothing.

    """

    mapping: CameraMapping
    ground: Floats
    image: Floats
    residual: Floats
    left_out: Floats
    noise_px: float
    oddity: str

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

    Estimated are the pose, the focal length, the principal point, the aspect ratio and OpenCV's
    five terms of the lens: those of the highest probability after the clicks, for lenses as
    `LensPrior` has them. A click that is far off counts for little (soft L1 beyond 2.5 times the
    noise, then by weight). The covariance is that of the normal distribution about the estimate.

    Parameters
    ----------
    ground : (n, 2) array_like
        The points, m.
    image : (n, 2) array_like
        Their pixels.
    image_size : (int, int)
        Width and height of the image, px.
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
    _check(places, image, click_noise_px)
    origin: Floats = places.mean(axis=0)
    ground = places - origin
    prior = LensPrior(image_size)
    stated_px = np.full(len(ground), click_noise_px)
    starts = _starts(ground, image, image_size) if start is None else [start.moved(-origin)]
    camera = _solved([CameraProblem(each, ground, image, prior, stated_px) for each in starts])
    weighed_px, noise_px = _weighed(camera, ground, image, prior, click_noise_px)
    camera, _ = CameraProblem(camera, ground, image, prior, weighed_px).solved(is_robust=False)
    found = CameraProblem(camera, ground, image, prior, weighed_px)
    covariance, _ = found.covariance()
    residual = _residual(camera, ground, image, image_size)
    mapping = CameraMapping(replace(camera, covariance=covariance), image_size, image)
    _check_fold(mapping, ground)
    _check_informative(mapping, ground)
    left_out = _left_out(mapping, ground, residual, weighed_px)
    oddity = prior.oddity(found.first)
    return CameraFit(mapping.moved(origin), places, image, residual, left_out, noise_px, oddity)


def _weighed(
    camera: Camera, ground: Floats, image: Floats, prior: LensPrior, click_noise_px: float
) -> tuple[Floats, float]:
    """Return the noise of each click (n,), the wild ones', too, and that of a usual one, px."""
    residual = _residual(camera, ground, image, prior.image_size)
    weight = _weights(residual, click_noise_px)
    weighed_px = click_noise_px / np.sqrt(weight)
    _, fixed = CameraProblem(camera, ground, image, prior, weighed_px).covariance()
    noise_px = _noise(residual, weight, click_noise_px, 2 * len(ground) - fixed)
    return weighed_px * (noise_px / click_noise_px), noise_px


def _solved(problems: list[CameraProblem]) -> Camera:
    """
    Return the camera that misses the points least, from the starts that miss least.

    One that misses by no more than clicks do is taken at once.
    """
    if not problems:
        raise FitError(SWAPPED)
    problems.sort(key=lambda problem: float(np.abs(problem.misses(problem.first)).sum()))
    solved: list[tuple[Camera, float]] = []
    for problem in problems[:TRIED]:
        solved.append(problem.solved(is_robust=True))
        if solved[-1][1] <= gammaincinv(problem.clicks, BELIEVED):  # half of chi-squared
            break
    camera, _ = min(solved, key=lambda found: found[1])
    return camera


def _residual(
    camera: Camera, ground: Floats, image: Floats, image_size: tuple[int, int]
) -> Floats:
    """Return clicked minus seen, (n, 2) px; `FitError` where a camera misses by an image."""
    residual = image - CameraMapping(camera, image_size).unfolded(ground)
    farthest = float(np.abs(image - np.divide(image_size, 2)).max())
    if not np.abs(residual).max() <= farthest:
        raise FitError(SWAPPED)
    return residual


def _check(ground: Floats, image: Floats, noise_px: float) -> None:
    if len(ground) != len(image):
        raise FitError(f'{len(ground)} ground points and {len(image)} pixels')
    if not (np.isfinite(ground).all() and np.isfinite(image).all()):
        raise FitError('a point is not finite')
    if len(np.unique(ground, axis=0)) != len(ground):
        raise FitError('two points lie at the same place on the ground')
    if len(ground) < FEWEST:
        raise FitError(
            f'{len(ground)} points are under-determined, expected at least {FEWEST} for a camera'
        )
    for name, points in (('on the ground', ground), ('in the image', image)):
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] < 1e-3 * spread[0]:
            raise FitError(f'the points lie on a line {name}: they fix no camera')
    deviation = spread[1] / np.sqrt(len(image))
    if deviation < NEAREST * noise_px:
        raise FitError(
            f'the points are under-determined: they deviate by {deviation:.1f} px alone in the '
            'image; add points that are spread over it'
        )


def _check_fold(mapping: CameraMapping, ground: Floats) -> None:
    """Refuse a lens that folds its image over where its own points are."""
    folded = int(np.isnan(mapping.image_from_ground(ground)[:, 0]).sum())
    if folded > MOST_FOLDED * len(ground):
        raise FitError(
            f'no lens of five terms sees the points so: it would fold the image over before '
            f'{folded} of them; is it a fisheye?'
        )


def _check_informative(mapping: CameraMapping, ground: Floats) -> None:
    """Refuse a camera that its own points do not pin down."""
    covariance = mapping.calibration_covariance(ground)
    deviation = float(np.sqrt(np.nanmax(np.trace(covariance, axis1=1, axis2=2))))
    extent = float(np.linalg.norm(np.ptp(ground, axis=0)))
    if not deviation <= LARGEST_ERROR * extent:
        raise FitError(
            f'the points are under-determined: the camera fitted to them is uncertain by '
            f'{deviation:.2g} m at its own points; add points that are spread over the image'
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


def _left_out(
    mapping: CameraMapping, ground: Floats, residual: Floats, noise_px: Floats
) -> Floats:
    """Return the residuals, (n, 2) px, as if each point had not pulled the camera along."""
    slopes = mapping.parameter_jacobian(ground)
    pulled = slopes @ mapping.camera.covariance @ slopes.swapaxes(1, 2)
    kept = np.eye(2) - pulled / noise_px[:, None, None] ** 2
    return np.asarray(np.linalg.solve(kept, residual[..., None])[..., 0], np.float64)


def _weights(residual: Floats, noise_px: float) -> Floats:
    """Return the weight of each point, (n,): 1 unless it is a wild click."""
    distance = np.linalg.norm(residual, axis=1) / (WILD * noise_px)
    weight: Floats = 1 / np.maximum(distance, 1.0) ** 2
    return weight


def _noise(residual: Floats, weight: Floats, stated_px: float, freedom: float) -> float:
    """Return the noise of a click along one axis, px: as stated, unless the misses belie it."""
    missed = float((weight[:, None] * residual**2).sum())
    usual = 2 * gammaincinv(freedom / 2, BELIEVED)  # so much at most, chi-squared
    if missed <= stated_px**2 * usual:
        return stated_px
    return float(np.sqrt(missed / freedom))
