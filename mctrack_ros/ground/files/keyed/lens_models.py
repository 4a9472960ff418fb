"""Lens models of calibration files, by the names their tools give them, as OpenCV's terms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.camera.lens import (
    WIDEST,
    distorted,
    farthest_radius,
    fit_lens,
    nearest_lens,
    seen_directions,
)
from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import plain

Floats = NDArray[np.float64]
Lens = tuple[Floats, Floats, float]
"""Intrinsics (4,), OpenCV's terms (5,) or (8,), and how far at most they miss a lens, px."""
ANGLES = 400
OWN_TERMS = 8
"""Number of OpenCV's terms that are kept; the others are for thin prisms and a tilted sensor."""
TERMS = {
    'none': 0,
    'plumb_bob': 5,
    'rational_polynomial': 14,
    'equidistant': 4,
    'fov': 1,
}
"""How many terms each model has at most."""
NAMES: dict[str, str] = {
    'none': 'none',
    'plumbbob': 'plumb_bob',
    'brownconrady': 'plumb_bob',
    'radialtangential': 'plumb_bob',
    'radtan': 'plumb_bob',
    'rationalpolynomial': 'rational_polynomial',
    'rational': 'rational_polynomial',
    'thinprism': 'rational_polynomial',
    'tilted': 'rational_polynomial',
    'equidistant': 'equidistant',
    'equi': 'equidistant',
    'fisheye': 'equidistant',
    'opencvfisheye': 'equidistant',
    'kannalabrandt': 'equidistant',
    'kannalabrandt4': 'equidistant',
    'kb4': 'equidistant',
    'fov': 'fov',
    'pinhole': '',
    'perspective': '',
}
"""What models are called, without case and punctuation; empty: the name says nothing of a lens."""


def lens_model(name: object) -> str:
    """
    Return which of `TERMS` a name means; empty: a camera without a word about its lens.

    Raises
    ------
    CalibrationError
        If it is not known.

    """
    known = plain(name)
    if known and known not in NAMES:
        raise CalibrationError(
            f'lens model is {str(name)!r}, expected one of {sorted(TERMS)} (or fisheye, for '
            'equidistant)'
        )
    return NAMES.get(known, '')


def lens_of(
    model: str, intrinsics: Floats, coefficients: ArrayLike, image_size: tuple[int, int]
) -> Lens:
    """
    Return intrinsics, OpenCV's five or eight terms, and how far at most they miss a lens, px.

    Parameters
    ----------
    model : str
        One of `TERMS`.
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    coefficients : array_like
        In OpenCV's order; trailing zeros may be missing or too many.
    image_size : (int, int)
        Width and height of the images, px.

    Raises
    ------
    CalibrationError
        If the lens has too many terms, or is not followed.

    """
    terms = np.trim_zeros(np.asarray(coefficients, np.float64).ravel(), 'b')
    if not np.isfinite(terms).all():
        raise CalibrationError('a term of the lens is not finite')
    if len(terms) > TERMS[model]:
        raise CalibrationError(
            f'the lens has {len(terms)} terms, expected at most {TERMS[model]} for {model}'
        )
    if model == 'equidistant':
        return _around_axis(intrinsics, _equidistant(terms), image_size)
    if model == 'fov' and terms.any():
        return _around_axis(intrinsics, _field_of_view(float(terms[0])), image_size)
    terms = np.pad(terms, (0, max(OWN_TERMS - len(terms), 0)))
    if terms[OWN_TERMS:].any():
        direction, pixel = seen_directions(intrinsics, terms, image_size)
        return nearest_lens(intrinsics, terms[:OWN_TERMS], direction, pixel)
    return intrinsics, terms[:OWN_TERMS] if terms[5:].any() else terms[:5], 0.0


def mirror_lens(
    model: str,
    shape: tuple[float, ...],
    intrinsics: Floats,
    terms: Floats,
    image_size: tuple[int, int],
) -> Lens:
    """
    Return OpenCV's lens that follows one of the unified models, with a lens of its own behind.

    Parameters
    ----------
    model : str
        One of `MIRRORS`.
    shape : tuple of float
        Its parameters, in Kalibr's order.
    intrinsics : (4,) array
        Focal lengths across and down, principal point across and down, px.
    terms : (n,) array
        Up to k1, k2, p1, p2, of what lies behind (`omni-radtan`).
    image_size : (int, int)
        Width and height of the images, px.

    Raises
    ------
    CalibrationError
        If it is not followed.

    """
    k1, k2, p1, p2 = np.pad(terms, (0, 4 - len(terms)))
    ideal = MIRRORS[model](*shape)

    def shown(angle: Floats) -> Floats:
        radius = ideal(angle)
        bent: Floats = radius * (1 + radius**2 * (k1 + radius**2 * k2))
        return bent

    found, lens, missed = _around_axis(intrinsics, shown, image_size)
    if not (p1 or p2):
        return found, lens, missed
    direction, _ = seen_directions(found, lens, image_size)
    away = np.linalg.norm(direction, axis=1)
    mirrored = direction * (ideal(np.arctan(away)) / away)[:, None]
    pixel = distorted(intrinsics, np.array([k1, k2, p1, p2, 0.0]), mirrored)
    return nearest_lens(found, np.pad(lens, (0, OWN_TERMS - len(lens))), direction, pixel)


def _equidistant(terms: Floats) -> Callable[[Floats], Floats]:
    """Return OpenCV's fisheye model: where it shows an angle, by the focal length."""
    k1, k2, k3, k4 = np.pad(terms, (0, 4 - len(terms)))

    def shown(angle: Floats) -> Floats:
        square = angle * angle
        radius: Floats = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
        return radius

    return shown


def _field_of_view(width: float) -> Callable[[Floats], Floats]:
    """Return the FOV model (Devernay and Faugeras 2001, equation 13) of a field, rad."""
    if not 0 < width < np.pi:
        raise CalibrationError(f'the term of the fov model is {width:g}, expected 0 to pi')
    return lambda angle: np.arctan(2 * np.tan(angle) * np.tan(width / 2)) / width


def _omnidirectional(xi: float) -> Callable[[Floats], Floats]:
    """Return the unified model (Mei and Rives 2007)."""
    return lambda angle: np.sin(angle) / (np.cos(angle) + xi)


def _double_sphere(xi: float, alpha: float) -> Callable[[Floats], Floats]:
    """Return the double sphere model (Usenko, Demmel and Cremers 2018, equation 40)."""

    def shown(angle: Floats) -> Floats:
        depth = np.cos(angle) + xi
        return np.sin(angle) / (alpha * np.hypot(np.sin(angle), depth) + (1 - alpha) * depth)

    return shown


def _extended(alpha: float, beta: float) -> Callable[[Floats], Floats]:
    """Return the extended unified model (Khomutenko, Garcia and Martinet 2016)."""

    def shown(angle: Floats) -> Floats:
        away = np.sqrt(beta * np.sin(angle) ** 2 + np.cos(angle) ** 2)
        radius: Floats = np.sin(angle) / (alpha * away + (1 - alpha) * np.cos(angle))
        return radius

    return shown


MIRRORS: dict[str, Callable[..., Callable[[Floats], Floats]]] = {
    'omni': _omnidirectional,
    'ds': _double_sphere,
    'eucm': _extended,
}
"""Unified models by Kalibr's names: parameters -> where an angle is shown, by the focal length."""


def _around_axis(
    intrinsics: Floats, shown_at: Callable[[Floats], Floats], image_size: tuple[int, int]
) -> Lens:
    """Return the lens that follows one around its axis, as far as that leads outwards."""
    angle = np.linspace(0, WIDEST, ANGLES)[1:]
    shown = shown_at(angle)
    kept = np.logical_and.accumulate(np.diff(shown, prepend=0.0) > 0)
    kept &= shown <= farthest_radius(intrinsics, image_size)
    return fit_lens(intrinsics, np.tan(angle[kept]), shown[kept])
