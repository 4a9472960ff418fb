"""One homography fitted to clicked points, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from mctrack_ros.ground.homography.covariance import by_entries, spread_terms
from mctrack_ros.ground.support import hull_of

Floats = NDArray[np.float64]
UNKNOWNS = 8
START_PX = 3.0
ROBUST_SCALE = 2.5
DEVIATION = 1.4826
"""Of a normal distribution, by its median distance from the middle."""
WILD = 3.5
"""Distance of a click from where it is expected from which it is wild, in noises."""
POLISHED = 3
LEAST_PX = 1e-3
FAR = 1e4
"""What a point behind the camera misses by, in robust scales."""


@dataclass(frozen=True, eq=False, slots=True)
class HomographyFit:
    """
    A homography from the ground to the image, and its uncertainty.

    Attributes
    ----------
    matrix : (3, 3) array
        Homogeneous ground coordinates in the frame of the points to pixels.
    frame : (3, 3) array
        From metres to that frame: the points' centre and extent are its unit.
    terms : (6, 6) array
        Of the matrix's covariance, as `homography_spread.add_spread` takes it.
    misfit_px2 : float
        Variance along an axis of what one homography cannot show, px²: a bent lens.
    hull : (k, 2) array
        Around the points in the image, px.

    """

    matrix: Floats
    frame: Floats
    terms: Floats
    misfit_px2: float
    hull: Floats


def start_homography(ground: Floats, image: Floats) -> Floats:
    """
    Return a homography, (3, 3), from most of some points, wild clicks left out (RANSAC).

    Raises
    ------
    ValueError
        If there are fewer than four points or all lie on a line.

    """
    if len(ground) < 4:
        raise ValueError(f'{len(ground)} points, expected at least 4')
    origin = ground.mean(axis=0)  # OpenCV computes in float32
    homography, _ = cv2.findHomography(ground - origin, image, cv2.RANSAC, START_PX)
    if homography is None or np.linalg.matrix_rank(ground - ground.mean(axis=0)) < 2:
        raise ValueError('the points lie on a line: they fix no homography')
    matrix = np.asarray(homography, np.float64)
    matrix[:, 2] -= matrix[:, :2] @ origin
    return matrix


def fit_homography(ground: Floats, image: Floats, click_noise_px: float) -> HomographyFit:
    """
    Fit a homography to all points; wild clicks count for little (soft L1, then by weight).

    The noise of a click is as stated or, if larger, as found. What is larger than stated is also
    taken for a misfit of the homography itself, which stays however many points there are.

    Parameters
    ----------
    ground, image : (n, 2) arrays
        The points, m, and their pixels.
    click_noise_px : float
        Standard deviation of a click along one axis, px.

    Raises
    ------
    ValueError
        If there are fewer than four points or all lie on a line.

    """
    start = start_homography(ground, image)
    frame = _frame(ground)
    places = (ground - ground.mean(axis=0)) * frame[0, 0]
    matrix = start @ np.linalg.inv(frame)
    missed = np.linalg.norm(_misses(matrix / matrix[2, 2], places, image), axis=1)
    noise_px = max(click_noise_px, DEVIATION * float(np.median(missed)), LEAST_PX)
    matrix = _solved(matrix / matrix[2, 2], places, image, ROBUST_SCALE * noise_px)
    for _ in range(POLISHED):  # a wild click still pulls at soft L1, wherever it is
        matrix = _polished(matrix, places, image, WILD * noise_px)
    misses = _misses(matrix, places, image)
    weight = _weights(misses, WILD * noise_px)
    freedom = max(2 * len(ground) - UNKNOWNS, 1)
    found_px2 = float((weight[:, None] * misses**2).sum()) / freedom
    covariance = _scatter(matrix, places, weight) * max(found_px2, click_noise_px**2)
    misfit_px2 = max(found_px2 - click_noise_px**2, 0.0)
    return HomographyFit(matrix, frame, spread_terms(covariance), misfit_px2, hull_of(image))


def _scatter(matrix: Floats, places: Floats, weight: Floats) -> Floats:
    """Return the (9, 9) covariance of a matrix's entries for clicks of 1 px, weighed (n,)."""
    jacobian = by_entries(matrix, places)[:, :, :UNKNOWNS]
    information = np.einsum('n,nik,nil->kl', weight, jacobian, jacobian)
    covariance = np.zeros((9, 9))
    covariance[:UNKNOWNS, :UNKNOWNS] = np.linalg.pinv(information, hermitian=True)
    return covariance


def _frame(ground: Floats) -> Floats:
    """Return the (3, 3) matrix that puts points about the origin, as far as 1 away."""
    centre = ground.mean(axis=0)
    scale = 1 / float(np.abs(ground - centre).max())
    return np.array([[scale, 0, -scale * centre[0]], [0, scale, -scale * centre[1]], [0, 0, 1.0]])


def _misses(matrix: Floats, places: Floats, image: Floats) -> Floats:
    """Return how far, (n, 2) px, a homography puts places from their pixels."""
    mapped = np.column_stack([places, np.ones(len(places))]) @ matrix.T
    ahead = mapped[:, 2:] > 0
    misses: Floats = np.where(ahead, mapped[:, :2] / np.where(ahead, mapped[:, 2:], 1), FAR)
    return misses - image


def _weights(misses: Floats, wild_px: float) -> Floats:
    """Return the weight of each point, (n,): 1 unless it is a wild click."""
    weight: Floats = 1 / np.maximum(np.linalg.norm(misses, axis=1) / wild_px, 1.0) ** 2
    return weight


def _polished(matrix: Floats, places: Floats, image: Floats, wild_px: float) -> Floats:
    """Return the homography after a step of least squares by the weights of its points."""
    misses = _misses(matrix, places, image)
    weight = np.sqrt(_weights(misses, wild_px))
    slopes = by_entries(matrix, places)[:, :, :UNKNOWNS] * weight[:, None, None]
    target = (misses * weight[:, None]).ravel()
    step = np.linalg.lstsq(slopes.reshape(-1, UNKNOWNS), target, rcond=None)[0]
    return np.append(matrix.ravel()[:UNKNOWNS] - step, 1.0).reshape(3, 3)


def _solved(start: Floats, places: Floats, image: Floats, scale_px: float) -> Floats:
    """Return the homography that misses the points least, its last entry 1."""

    def matrix(values: Floats) -> Floats:
        return np.append(values, 1.0).reshape(3, 3)

    def misses(values: Floats) -> Floats:
        missed: Floats = _misses(matrix(values), places, image).ravel() / scale_px
        return missed

    def derivatives(values: Floats) -> Floats:
        slopes: Floats = by_entries(matrix(values), places)[:, :, :UNKNOWNS]
        return slopes.reshape(-1, UNKNOWNS) / scale_px

    first = start.ravel()[:UNKNOWNS]
    return matrix(least_squares(misses, first, derivatives, loss='soft_l1', x_scale='jac').x)
