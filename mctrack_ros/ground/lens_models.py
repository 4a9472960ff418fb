"""Lens models of calibration files, by the names ROS gives them, as OpenCV's five terms."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.lens import fit_lens, seen_directions

Floats = NDArray[np.float64]
TERMS = {'plumb_bob': 5, 'rational_polynomial': 8, 'equidistant': 4}


def lens_of(
    model: str, intrinsics: Floats, coefficients: ArrayLike, image_size: tuple[int, int]
) -> tuple[Floats, Floats, float]:
    """
    Return intrinsics, k1, k2, p1, p2 and k3 for a lens, and how far at most they miss it, px.

    Parameters
    ----------
    model : str
        ``plumb_bob``, ``rational_polynomial`` or ``equidistant``; empty: ``plumb_bob``.
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    coefficients : array_like
        In OpenCV's order; trailing zeros may be missing or too many.
    image_size : (int, int)
        Width and height of the pictures, px.

    Raises
    ------
    CalibrationError
        If the model is not known, has too many terms, or five terms do not follow it.

    """
    terms = np.trim_zeros(np.asarray(coefficients, np.float64).ravel(), 'b')
    model = model or 'plumb_bob'
    if model not in TERMS:
        raise CalibrationError(f'lens model is {model!r}, expected one of {sorted(TERMS)}')
    if not np.isfinite(terms).all():
        raise CalibrationError('a term of the lens is not finite')
    if len(terms) > TERMS[model]:
        raise CalibrationError(
            f'the lens has {len(terms)} terms, expected at most {TERMS[model]} for {model}'
        )
    terms = np.pad(terms, (0, TERMS[model] - len(terms)))
    if model == 'plumb_bob' or (model == 'rational_polynomial' and not terms[5:].any()):
        return intrinsics, terms[:5], 0.0
    place = _rational if model == 'rational_polynomial' else _equidistant
    pixel_of = partial(_pixels, intrinsics, partial(place, terms))
    direction, pixel = seen_directions(pixel_of, intrinsics[2:], image_size)
    return fit_lens(intrinsics, pixel, direction)


def _pixels(intrinsics: Floats, place: partial[Floats], direction: Floats) -> Floats:
    pixel: Floats = place(direction) * intrinsics[:2] + intrinsics[2:]
    return pixel


def _rational(terms: Floats, direction: Floats) -> Floats:
    """Return where OpenCV's rational model puts (n, 2) directions."""
    k1, k2, p1, p2, k3, k4, k5, k6 = terms
    x, y = direction.T
    square = x * x + y * y
    radial = (1 + square * (k1 + square * (k2 + square * k3))) / (
        1 + square * (k4 + square * (k5 + square * k6))
    )
    return np.column_stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
            y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
        ]
    )


def _equidistant(terms: Floats, direction: Floats) -> Floats:
    """Return where OpenCV's fisheye model puts (n, 2) directions."""
    radius = np.linalg.norm(direction, axis=1, keepdims=True)
    angle = np.arctan(radius)
    square = angle * angle
    k1, k2, k3, k4 = terms
    bent = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
    place: Floats = direction * bent / np.maximum(radius, 1e-12)
    return place
