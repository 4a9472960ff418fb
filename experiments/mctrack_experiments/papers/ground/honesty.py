"""Whether the errors that mappings predict for themselves are those that occur."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from mctrack_experiments.papers.ground.accuracy import (
    CLICK_NOISE_PX,
    IMAGE_SIZE,
    LENS_BOUNDS,
    drawn_lens,
    looking,
    with_lens,
)
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import (
    METHODS,
    CalibrationError,
    CameraMapping,
    GroundMapping,
    fit_camera,
    grid_from_points,
    mapping_from_grid,
)

Floats = NDArray[np.float64]

CAMERAS = 200
MOST_POINTS, FEWEST_POINTS = 40, 20
GRID_M = 4.0
PLACES = 3
BAND = 0.95
METHOD_CAMERAS = 40
CLICKED_SHARE = 0.8
METHOD_PLACES = 100
REACH_M = 60.0
EDGES: dict[str, dict[str, float]] = {
    'middle': {},
    'principal_10_0': {'across_px': 10},
    'principal_0_10': {'down_px': 10},
    'principal_20_15': {'across_px': 20, 'down_px': 15},
    'k2_above': {'k2': 0.05},
    'k2_below': {'k2': -0.05},
    'aspect_above': {'aspect': 0.01},
    'aspect_below': {'aspect': -0.01},
    'all': {'across_px': -20, 'down_px': 20, 'k2': 0.05, 'aspect': 0.01},
}
"""Lenses in the middle and at the edges of what is drawn."""


def reproduce_honesty() -> Figures:
    """Measure `honesty` with its protocol."""
    protocol = {
        'cameras': f'{CAMERAS}, random; k1 -0.3 to 0.1',
        'lens': f'drawn evenly up to {LENS_BOUNDS} off: the principal point from the middle, the '
        "aspect ratio from 1, and OpenCV's terms; the fitted camera has no k4",
        'edge': f'{CAMERAS} random cameras each, all with one lens: {EDGES}, else as usual',
        'points': f'{FEWEST_POINTS} to {MOST_POINTS} of a {GRID_M:g} m grid',
        'click_noise_px': CLICK_NOISE_PX,
        'nees': f'errors of {PLACES} places a camera, pixels exact, over their joint covariance',
        'coverage': f'share of cameras whose error is within the {BAND:.0%} that it predicts',
        'low, high': f'of the mean, {BAND:.0%} of a chi-square distribution',
        'methods': f'{METHOD_CAMERAS} random cameras, all points of the {GRID_M:g} m grid in the '
        f'middle {CLICKED_SHARE:.0%} of the image clicked; {METHOD_PLACES} pixels with 0.5 px '
        f'noise up to {REACH_M:g} m away; inside: not extrapolated; 2 is honest, less cautious',
    }
    figures = honesty()
    edges = {name: honesty(lens=lens) for name, lens in EDGES.items()}
    for name, found in edges.items():
        figures |= {f'edge.{name}.{key}': found[f'nees.{key}'] for key in ('mean', 'coverage')}
    figures['edge.mean_max'] = max(found['nees.mean'] for found in edges.values())
    figures |= honesty_of_methods()
    return Figures('honesty', 'mctrack reproduce honesty', protocol, figures)


def honesty(cameras: int = CAMERAS, lens: Mapping[str, float] | None = None) -> dict[str, float]:
    """
    Return the mean normalised error squared (NEES) of fitted cameras, and its band.

    Each of the random cameras is fitted to 20 to 40 points of a 4 m grid clicked with 0.5 px of
    noise; the errors of three places, their pixels exact, are held against their joint covariance
    by the fit. An honest fit has a mean of 2 a place, within the band of a chi-square
    distribution, and covers 95 % of the cameras.

    Parameters
    ----------
    cameras : int
        How many.
    lens : mapping, optional
        How all lenses deviate, as `with_lens` takes it; unless given, each is drawn.

    """
    nees = np.array([_normalised_error(seed, lens) for seed in range(cameras)])
    covered = PLACES * nees <= chi2.ppf(BAND, 2 * PLACES)
    low, high = chi2.ppf([(1 - BAND) / 2, (1 + BAND) / 2], 2 * PLACES * cameras)
    low, high = low / PLACES / cameras, high / PLACES / cameras
    return {
        'nees.mean': float(nees.mean()),
        'nees.coverage': float(covered.mean()),
        'nees.low': float(low),
        'nees.high': float(high),
    }


def honesty_of_methods(cameras: int = METHOD_CAMERAS) -> dict[str, float]:
    """
    Return each method's mean normalised error squared, inside and outside its points.

    Parameters
    ----------
    cameras : int
        How many, random.

    """
    found: dict[str, list[Floats]] = {}
    for seed in range(cameras):
        random = np.random.default_rng(seed)
        truth, maps = _mapped_by_all(random)
        place = truth.ground_from_image(random.uniform(0, 1, (METHOD_PLACES, 2)) * IMAGE_SIZE)
        place = place[(np.abs(place) < REACH_M).all(axis=1)]
        seen = truth.image_from_ground(place)
        seen += random.normal(0, CLICK_NOISE_PX, seen.shape)
        for method, mapping in maps.items():
            position, covariance = mapping.locate(seen, CLICK_NOISE_PX**2 * np.eye(2))
            error = (position - place)[..., None]
            nees = (error * np.linalg.solve(covariance, error)).sum(axis=(1, 2))
            outside = mapping.is_extrapolated(seen)
            found.setdefault(f'{method}.nees.inside', []).append(nees[~outside])
            found.setdefault(f'{method}.nees.outside', []).append(nees[outside])
    return {name: float(np.nanmean(np.concatenate(each))) for name, each in found.items()}


def _mapped_by_all(
    random: np.random.Generator,
) -> tuple[CameraMapping, dict[str, GroundMapping]]:
    """Return a random camera, and what each method makes of its clicked points."""
    while True:
        truth = _random_camera(random)
        points = _seen(truth)
        pixel = truth.image_from_ground(points)
        middle = np.abs(pixel / IMAGE_SIZE - 0.5).max(axis=1) < CLICKED_SHARE / 2
        points = points[middle]
        clicks = pixel[middle] + random.normal(0, CLICK_NOISE_PX, points.shape)
        names = [f'{x:g}/{y:g}' for x, y in points]
        try:
            grid, _ = grid_from_points('camera', names, points, clicks)
            return truth, {each: mapping_from_grid(grid, IMAGE_SIZE, each) for each in METHODS}
        except CalibrationError:
            continue


def _normalised_error(seed: int, lens: Mapping[str, float] | None) -> float:
    random = np.random.default_rng(seed)
    points = np.zeros((0, 2))
    while len(points) < FEWEST_POINTS:
        mapping = _random_camera(random, lens)
        points = _seen(mapping)
    chosen = random.choice(len(points), min(len(points), MOST_POINTS), replace=False)
    points = points[np.sort(chosen)]
    clicks = mapping.image_from_ground(points) + random.normal(0, CLICK_NOISE_PX, points.shape)
    fitted = fit_camera(points, clicks, IMAGE_SIZE, CLICK_NOISE_PX).mapping
    place = random.choice(points, PLACES, replace=False) + random.uniform(-1, 1, (PLACES, 2))
    error = fitted.ground_from_image(mapping.image_from_ground(place)) - place
    inverse = np.linalg.inv(fitted.image_jacobian(place))
    by_camera = (inverse @ fitted.parameter_jacobian(place)).reshape(2 * PLACES, -1)
    covariance = by_camera @ fitted.camera.covariance @ by_camera.T
    return float(error.ravel() @ np.linalg.solve(covariance, error.ravel())) / PLACES


def _random_camera(
    random: np.random.Generator, lens: Mapping[str, float] | None = None
) -> CameraMapping:
    """Return a random camera with a lens, drawn unless given."""
    eye = random.uniform((-10, -40, 5), (10, -15, 25))
    target = np.array([*random.uniform((-5, 0), (5, 15)), 0.0])
    camera = looking(eye, target, random.uniform(450, 1000), random.uniform(-0.3, 0.1))
    lens = drawn_lens(random) if lens is None else lens
    return CameraMapping(with_lens(camera, lens), IMAGE_SIZE)


def _seen(mapping: CameraMapping) -> np.ndarray:
    axis = np.arange(-60, 61, GRID_M)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    pixel = mapping.image_from_ground(points)
    return points[(pixel >= 0).all(axis=1) & (pixel < IMAGE_SIZE).all(axis=1)]
