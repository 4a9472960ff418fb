"""OpenCV's lens of eight terms (the rational model), its derivatives and its inverse."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import inner

Floats = NDArray[np.float64]
TERMS = 8
"""k1 k2 p1 p2 k3 k4 k5 k6."""
DERIVED = 7
"""How many numbers `distort` writes."""
NO_LIMIT = 1e12
"""Square of the largest radius of a lens that has none."""
NEWTON_STEPS = 20
CONVERGED = 1e-12
SURE = 0.99
"""Share of the largest radius up to which Newton's method finds the way back."""


def packed_lens(intrinsics: Floats, distortion: Floats) -> Floats:
    """Return intrinsics, eight terms, and the square of the largest radius: (13,)."""
    radius = min(turning_radius(distortion), pole_radius(distortion))
    rest = np.zeros(TERMS - len(distortion))
    return np.concatenate([intrinsics, distortion, rest, [radius**2]])


def turning_radius(distortion: Floats) -> float:
    """Return up to which undistorted radius the lens keeps the order of radii: it folds there."""
    k1, k2, _, _, k3 = distortion[:5]
    if not distortion[5:].any():
        return _least_root(np.array([7 * k3, 5 * k2, 3 * k1, 1.0]))
    top, bottom = Polynomial([1.0, k1, k2, k3]), _denominator(distortion)
    slope = top.deriv() * bottom - top * bottom.deriv()
    return _least_root((top * bottom + Polynomial([0.0, 2.0]) * slope).coef[::-1])


def pole_radius(distortion: Floats) -> float:
    """Return at which undistorted radius the lens's denominator is zero: pixels are far there."""
    if not distortion[5:].any():
        return float(np.sqrt(NO_LIMIT))
    return _least_root(_denominator(distortion).coef[::-1])


def _denominator(distortion: Floats) -> Polynomial:
    """Return what the radial factor is divided by, by the square of the radius."""
    return Polynomial([1.0, *distortion[5:]])


def _least_root(polynomial: ArrayLike) -> float:
    """Return the root of the least positive root of a polynomial in squares; if any."""
    squares = np.roots(np.asarray(polynomial))
    real = [root.real for root in squares if abs(root.imag) < 1e-12 and root.real > 0]
    return float(np.sqrt(min(real, default=NO_LIMIT)))


@inner
def distort(lens: Floats, x: float, y: float, out: Floats) -> None:
    """Write where the lens puts a direction: x, y, derivatives xx, xy, yx, yy, 1/denominator."""
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    k4, k5, k6 = lens[9], lens[10], lens[11]
    square = x * x + y * y
    share = 1.0 / (1.0 + square * (k4 + square * (k5 + square * k6)))
    radial = (1.0 + square * (k1 + square * (k2 + square * k3))) * share
    slope = 2.0 * (k1 + square * (2.0 * k2 + square * 3.0 * k3)) * share
    slope -= 2.0 * (k4 + square * (2.0 * k5 + square * 3.0 * k6)) * share * radial
    out[0] = x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x)
    out[1] = y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y
    out[2] = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    out[3] = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    out[4] = out[3]
    out[5] = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    out[6] = share


@inner
def undistort(lens: Floats, u: float, v: float, work: Floats) -> tuple[float, float]:
    """Return the direction that the lens puts at a pixel, by Newton's method; NaN if none."""
    goal_x, goal_y = (u - lens[2]) / lens[0], (v - lens[3]) / lens[1]
    x, y = goal_x, goal_y
    straight = True
    for term in range(4, 12):
        straight = straight and lens[term] == 0.0
    if straight:
        return x, y
    for _ in range(NEWTON_STEPS):
        square = x * x + y * y
        if square > lens[12]:
            inside = SURE * np.sqrt(lens[12] / square)
            x, y = x * inside, y * inside
        distort(lens, x, y, work)
        miss_x, miss_y = work[0] - goal_x, work[1] - goal_y
        if miss_x * miss_x + miss_y * miss_y < CONVERGED * CONVERGED:
            return x, y
        scale = work[2] * work[5] - work[3] * work[4]
        if scale <= 0.0:
            break
        x -= (work[5] * miss_x - work[3] * miss_y) / scale
        y -= (work[2] * miss_y - work[4] * miss_x) / scale
    return np.nan, np.nan
