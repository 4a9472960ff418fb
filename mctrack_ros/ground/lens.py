"""OpenCV's lens fitted to what another model of a lens does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.camera import largest_radius
from mctrack_ros.ground.errors import CalibrationError

Floats = NDArray[np.float64]
LARGEST_RESIDUAL_PX = 1.0
"""A lens that OpenCV's five coefficients do not follow so closely everywhere is refused."""
STRAIGHT_PX = 0.1
"""A lens that moves no pixel of the picture further is none."""
SAMPLES = (41, 31)
WIDEST = np.radians(85.0)
"""How far from the axis a lens is followed."""


def picture_samples(image_size: tuple[int, int]) -> Floats:
    """Return (n, 2) pixels spread evenly over a picture, its edges included."""
    axes = [np.linspace(0, side, count) for side, count in zip(image_size, SAMPLES)]
    pixels: Floats = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return pixels


def distorted(intrinsics: Floats, distortion: Floats, direction: Floats) -> Floats:
    """Return the (n, 2) pixels of (n, 2) directions at depth 1 through OpenCV's lens."""
    offset = _terms(direction) @ distortion
    pixel: Floats = (direction + offset) * intrinsics[:2] + intrinsics[2:]
    return pixel


def seen_directions(
    pixel_of: Callable[[Floats], Floats], centre: Floats, image_size: tuple[int, int]
) -> tuple[Floats, Floats]:
    """
    Return directions spread over what a lens shows in its picture, and their pixels.

    Parameters
    ----------
    pixel_of : callable
        Takes (n, 2) directions at depth 1 to (n, 2) pixels.
    centre : (2,) array
        Principal point, px.
    image_size : (int, int)
        Width and height of the picture, px.

    Returns
    -------
    direction, pixel : (n, 2) arrays
        Along each azimuth as far as the lens leads outwards, inside the picture.

    """
    radius = np.tan(np.linspace(0, WIDEST, 400))[1:]
    azimuth = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    around = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    direction = around[:, None] * radius[:, None]
    pixel = pixel_of(direction.reshape(-1, 2)).reshape(direction.shape)
    away = np.linalg.norm(pixel - centre, axis=2)
    outwards = np.diff(away, axis=1, prepend=0.0) > 0
    kept = np.logical_and.accumulate(outwards, axis=1)
    kept &= ((pixel >= 0) & (pixel <= image_size)).all(axis=2)
    return direction[kept], pixel[kept]


def bend_px(intrinsics: Floats, distortion: Floats, image_size: tuple[int, int]) -> float:
    """Return how far at most a lens moves what a pinhole would show, px."""
    if not distortion.any():
        return 0.0
    direction, pixel = seen_directions(
        lambda each: distorted(intrinsics, distortion, each), intrinsics[2:], image_size
    )
    straight = direction * intrinsics[:2] + intrinsics[2:]
    return float(np.linalg.norm(pixel - straight, axis=1).max())


def fit_lens(intrinsics: Floats, pixel: Floats, direction: Floats) -> tuple[Floats, Floats, float]:
    """
    Return the focal lengths and OpenCV's distortion that put directions at pixels.

    The distorted place is linear in k1, k2, p1, p2, k3 and a common factor of the focal lengths
    once the direction is known: one linear least-squares problem, in pixels.

    Parameters
    ----------
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px, of the other model.
    pixel : (n, 2) array
        Where the lens puts them.
    direction : (n, 2) array
        x and y of the undistorted directions, at depth 1.

    Returns
    -------
    intrinsics : (4,) array
        Of OpenCV's camera.
    distortion : (5,) array
        k1, k2, p1, p2, k3.
    residual_px : float
        The largest distance left, px.

    Raises
    ------
    CalibrationError
        If that is more than `LARGEST_RESIDUAL_PX`.

    """
    focal, centre = intrinsics[:2], intrinsics[2:]
    terms = np.concatenate([_terms(direction), direction[:, :, None]], axis=2)
    design, goal = terms * focal[:, None], pixel - centre
    scale = np.abs(design).max(axis=(0, 1))
    solved = np.linalg.lstsq(design.reshape(-1, 6) / scale, goal.ravel(), rcond=None)[0] / scale
    missed = float(np.linalg.norm(design @ solved - goal, axis=1).max())
    distortion = solved[:5] / solved[5]
    widest = (direction**2).sum(axis=1).max()
    if not missed <= LARGEST_RESIDUAL_PX or widest > largest_radius(distortion) ** 2:
        raise CalibrationError(
            f'no lens of five coefficients (k1 k2 p1 p2 k3) follows this one: it is up to '
            f'{missed:.2g} px off, expected at most {LARGEST_RESIDUAL_PX:g} px'
        )
    return np.concatenate([focal * solved[5], centre]), distortion, missed


def _terms(direction: Floats) -> Floats:
    """Return (n, 2, 5): what k1, k2, p1, p2 and k3 of one would add to directions."""
    x, y = direction.T
    square = x * x + y * y
    radial = [direction * (square**power)[:, None] for power in (1, 2, 3)]
    first = np.column_stack([2 * x * y, square + 2 * y * y])
    second = np.column_stack([square + 2 * x * x, 2 * x * y])
    return np.stack([radial[0], radial[1], first, second, radial[2]], axis=2)
