"""Lens models of calibration files, by the names ROS gives them, as OpenCV's terms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.lens import WIDEST, farthest_radius, fit_lens

Floats = NDArray[np.float64]
TERMS = {'plumb_bob': 5, 'rational_polynomial': 8, 'equidistant': 4}
ANGLES = 400


def lens_of(
    model: str, intrinsics: Floats, coefficients: ArrayLike, image_size: tuple[int, int]
) -> tuple[Floats, Floats, float]:
    """
    Return intrinsics, OpenCV's five or eight terms, and how far at most they miss a lens, px.

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
        If the model is not known, has too many terms, or is not followed.

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
    if model != 'equidistant':
        return intrinsics, terms if terms[5:].any() else terms[:5], 0.0
    return _equidistant(intrinsics, terms, image_size)


def _equidistant(
    intrinsics: Floats, terms: Floats, image_size: tuple[int, int]
) -> tuple[Floats, Floats, float]:
    """Return the lens that follows OpenCV's fisheye model, as far as it leads outwards."""
    angle = np.linspace(0, WIDEST, ANGLES)[1:]
    square = angle * angle
    k1, k2, k3, k4 = terms
    shown = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
    kept = np.logical_and.accumulate(np.diff(shown, prepend=0.0) > 0)
    kept &= shown <= farthest_radius(intrinsics, image_size)
    return fit_lens(intrinsics, np.tan(angle[kept]), shown[kept])
