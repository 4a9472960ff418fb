"""OpenCV's lens fitted to what another model of a lens does."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, lsq_linear

from mctrack_ros.ground.camera.distortion import SURE, TERMS, pole_radius, turning_radius
from mctrack_ros.ground.errors import CalibrationError

Floats = NDArray[np.float64]
LARGEST_RESIDUAL_PX = 1.0
"""A lens that OpenCV's coefficients do not follow so closely everywhere is refused."""
FINE_PX = 0.05
"""Error up to which k1, k2 and k3 are enough."""
REWEIGHTED = 6
STRAIGHT_PX = 0.1
"""A lens that moves no pixel of the image further is none."""
SAMPLES = (41, 31)
WIDEST = np.radians(85.0)
"""How far from the axis a lens is followed."""


def image_samples(image_size: tuple[int, int]) -> Floats:
    """Return (n, 2) pixels spread evenly over an image, its edges included."""
    axes = [np.linspace(0, side, count) for side, count in zip(image_size, SAMPLES)]
    pixels: Floats = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return pixels


def distorted(intrinsics: Floats, distortion: Floats, direction: Floats) -> Floats:
    """Return the (n, 2) pixels of (n, 2) directions at depth 1 through OpenCV's lens."""
    across, down, x, y = intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]])
    world = np.column_stack([direction, np.ones(len(direction))])
    pixel = cv2.projectPoints(world, np.zeros(3), np.zeros(3), matrix, distortion)[0]
    return np.asarray(pixel, np.float64).reshape(-1, 2)


def farthest_radius(intrinsics: Floats, image_size: tuple[int, int]) -> float:
    """Return how far off the principal point an image's farthest corner lies, at depth 1."""
    corners = np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) * image_size
    return float(np.linalg.norm((corners - intrinsics[2:]) / intrinsics[:2], axis=1).max())


def seen_directions(
    intrinsics: Floats, distortion: Floats, image_size: tuple[int, int]
) -> tuple[Floats, Floats]:
    """
    Return directions spread over what a lens shows in its image, and their pixels.

    Parameters
    ----------
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    distortion : (5,), (8,) or (14,) array
        Of OpenCV.
    image_size : (int, int)
        Width and height of the image, px.

    Returns
    -------
    direction, pixel : (n, 2) arrays
        Along each azimuth as far as the lens leads outwards, inside the image.

    """
    radius = np.tan(np.linspace(0, WIDEST, 400))[1:]
    azimuth = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    around = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    direction = around[:, None] * radius[:, None]
    pixel = distorted(intrinsics, distortion, direction.reshape(-1, 2)).reshape(direction.shape)
    away = np.linalg.norm(pixel - intrinsics[2:], axis=2)
    outwards = np.diff(away, axis=1, prepend=0.0) > 0
    kept = np.logical_and.accumulate(outwards, axis=1)
    kept &= radius <= SURE * pole_radius(distortion[:TERMS])
    kept &= ((pixel >= 0) & (pixel <= image_size)).all(axis=2)
    return direction[kept], pixel[kept]


def bend_px(intrinsics: Floats, distortion: Floats, image_size: tuple[int, int]) -> float:
    """Return how far at most a lens moves what a pinhole would show, px."""
    if not distortion.any():
        return 0.0
    direction, pixel = seen_directions(intrinsics, distortion, image_size)
    straight = direction * intrinsics[:2] + intrinsics[2:]
    return float(np.linalg.norm(pixel - straight, axis=1).max())


def fit_lens(intrinsics: Floats, radius: Floats, shown: Floats) -> tuple[Floats, Floats, float]:
    """
    Return the focal lengths and OpenCV's distortion that follow a lens around its axis.

    k1, k2 and k3 where they are enough (within `FINE_PX`), else the rational model's six: a
    linear least-squares problem in the terms and a common factor of the focal lengths, weighted
    by the denominator found before (Sanathanan and Koerner 1963).

    Parameters
    ----------
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px, of the other model.
    radius : (n,) array
        Distances of undistorted directions from the axis, at depth 1, above 0.
    shown : (n,) array
        Where the lens shows them: distances from the principal point by the focal length.

    Returns
    -------
    intrinsics : (4,) array
        Of OpenCV's camera.
    distortion : (5,) or (8,) array
        k1, k2, p1, p2, k3 (, k4, k5, k6).
    residual_px : float
        The largest distance left, px.

    Raises
    ------
    CalibrationError
        If that is more than `LARGEST_RESIDUAL_PX`.

    """
    focal = float(intrinsics[:2].max())
    polynomial = _solved(radius, shown, 0, np.ones(len(radius)))
    rational = _rational(radius, shown)
    if not rational.missed * focal <= LARGEST_RESIDUAL_PX:  # its denominator crosses zero
        rational = _rational(radius, shown, signed=True)
    best = polynomial if polynomial.missed * focal <= FINE_PX else rational
    missed = best.missed * focal
    _check_followed(missed)
    return np.concatenate([intrinsics[:2] * best.factor, intrinsics[2:]]), best.terms, missed


def nearest_lens(
    intrinsics: Floats, distortion: Floats, direction: Floats, pixel: Floats
) -> tuple[Floats, Floats, float]:
    """
    Return the intrinsics and eight terms that put directions nearest to where they are seen.

    The denominator (k4, k5, k6) stays as it is.

    Parameters
    ----------
    intrinsics : (4,) array
        To begin with: focal lengths across and down, principal point across and down, px.
    distortion : (8,) array
        To begin with.
    direction, pixel : (n, 2) arrays
        Directions at depth 1, and where they are seen, px.

    Returns
    -------
    intrinsics, distortion, residual_px
        As of `fit_lens`.

    Raises
    ------
    CalibrationError
        If a direction is missed by more than `LARGEST_RESIDUAL_PX`.

    """

    def lens(values: Floats) -> tuple[Floats, Floats]:
        return values[:4], np.concatenate([values[4:], distortion[5:]])

    def missed(values: Floats) -> Floats:
        return (distorted(*lens(values), direction) - pixel).ravel()

    values = least_squares(missed, np.append(intrinsics, distortion[:5]), x_scale='jac').x
    found, terms = lens(values)
    orderly = min(turning_radius(terms), pole_radius(terms)) >= np.hypot(*direction.T).max()
    most = float(np.hypot(*missed(values).reshape(-1, 2).T).max()) if orderly else np.inf
    _check_followed(most)
    return found, terms, most


def _check_followed(missed: float) -> None:
    if not missed <= LARGEST_RESIDUAL_PX:
        raise CalibrationError(
            f"OpenCV's lens of eight terms (k1 to k6, p1, p2) does not follow this one: it is up "
            f'to {missed:.2g} px off, expected at most {LARGEST_RESIDUAL_PX:g} px'
        )


@dataclass(frozen=True, eq=False, slots=True)
class _Solved:
    """One solution: factor of the focal lengths, terms, denominator, largest miss at depth 1."""

    factor: float
    terms: Floats
    bottom: Floats
    missed: float


def _rational(radius: Floats, shown: Floats, signed: bool = False) -> _Solved:
    """Return the best of the rational solutions, each weighted by the one before."""
    found, weight = [], np.ones(len(radius))
    for _ in range(REWEIGHTED):
        found.append(_solved(radius, shown, 3, weight, signed))
        weight = 1 / np.maximum(np.abs(found[-1].bottom), 1e-6)
    return min(found, key=lambda each: each.missed)


def _solved(
    radius: Floats, shown: Floats, below: int, weight: Floats, signed: bool = False
) -> _Solved:
    """
    Solve shown (1 + k4 s + ..) = radius (c + c k1 s + ..), s = radius², `below` terms below.

    If `signed`, those below are positive, so that there is no pole.

    """
    square = (radius**2)[:, None] / radius.max() ** 2
    design = np.hstack(
        [radius[:, None] * square ** np.arange(4), -shown[:, None] * square ** np.arange(1, 4)]
    )[:, : 4 + below] * weight[:, None]  # fmt: skip
    scale = np.abs(design).max(axis=0)
    least = np.where(signed & (np.arange(4 + below) > 3), 0.0, -np.inf)
    solved = lsq_linear(design / scale, shown * weight, (least, np.inf), 'bvls').x / scale
    solved /= radius.max() ** np.array([0, 2, 4, 6, 2, 4, 6])[: 4 + below]
    factor, upper, lower = float(solved[0]), solved[1:4] / solved[0], solved[4:]
    top = np.polyval([*upper[::-1], 1.0], radius**2)
    bottom = np.polyval([*lower[::-1], 1.0], radius**2)
    terms = np.array([upper[0], upper[1], 0.0, 0.0, upper[2], *lower])
    off = np.abs(factor * radius * top / bottom - shown).max()
    orderly = min(turning_radius(terms), pole_radius(terms)) >= radius.max()
    return _Solved(factor, terms, bottom, float(off) if orderly else np.inf)
