"""Outlines of upright solids of revolution in an image, with normals (section 4.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping

Floats = NDArray[np.float64]

POINTS = 64
"""Points of an outline, evenly along it."""
SHAPES: dict[str, tuple[Sequence[float], Sequence[float]]] = {
    'cylinder': ([0.0, 1.0], [1.0, 1.0]),
    'person': ([0.0, 0.5, 0.8, 0.86, 1.0], [0.7, 1.0, 1.0, 0.5, 0.4]),
    'ellipsoid': (
        [each / 16 for each in range(17)],
        [2 * (each / 16 * (1 - each / 16)) ** 0.5 for each in range(17)],
    ),
}
"""Heights as shares of the whole, and the radii there as shares of the largest."""
_ARC, _SIDE = 24, 24
"""Points along a rim and along a side before they are spread evenly."""


def outlines(
    mapping: GroundMapping,
    position: Floats,
    height: float,
    radius: float,
    shape: str,
) -> tuple[Floats, Floats]:
    """
    Return the outlines of solids of revolution and their normals, distortion included.

    The outline of the paper's cylinder is the image of the two lines along which rays graze the
    mantle, the half of the lower rim that faces the camera, and the half of the upper rim that
    does not if the camera is above it, else that which does. Where the radius changes with height
    a ray grazes as it would a cylinder of the radius there.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    position : (n, 2) array
        Their axes on the ground, m.
    height, radius : float
        Of each, m.
    shape : str
        One of `SHAPES`.

    Returns
    -------
    contour : (n, 64, 2) array
        px; NaN where a part is not to be seen by the camera, or it stands in the solid.
    normal : (n, 64) array
        Direction of the normal, rad, 0 to pi.

    """
    wide, level = _profile(height, radius, shape)
    camera = mapping.camera_position
    away = position - camera[:2]
    with np.errstate(invalid='ignore'):
        share = wide / np.hypot(*away.T)[:, None]
        graze = np.arccos(np.where(share < 1.0, -share, np.nan))
    towards = np.arctan2(away[:, 1], away[:, 0])[:, None]
    turn = towards + _turns(graze, is_above=bool(camera[2] > height))
    place = position[:, None] + wide[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    levels = np.tile(level, len(position))
    pixel = mapping.image_from_ground(place.reshape(-1, 2), levels).reshape(*turn.shape, 2)
    return _evenly(pixel)


def _profile(height: float, radius: float, shape: str) -> tuple[Floats, Floats]:
    """Return radius and height, m, of the points of an outline: rim, side, upper rim, side."""
    up = _unit(_SIDE)
    side = radius * np.interp(up, *SHAPES[shape])
    wide = np.concatenate([np.full(_ARC, side[0]), side, np.full(_ARC, side[-1]), side[::-1]])
    return wide, height * np.concatenate([np.zeros(_ARC), up, np.ones(_ARC), up[::-1]])


def _turns(graze: Floats, is_above: bool) -> Floats:
    """
    Return where about the axis the points of outlines are, rad from the direction away.

    The camera lies at pi and sees the mantle between the angles -`graze` and `graze`.
    """
    near = 2 * (np.pi - graze[:, :_ARC]) * _unit(_ARC)
    top = graze[:, _ARC + _SIDE : 2 * _ARC + _SIDE]
    rim = -2 * top * _unit(_ARC) if is_above else 2 * (np.pi - top) * _unit(_ARC)
    along = graze.copy()
    along[:, :_ARC] += near
    along[:, _ARC : _ARC + _SIDE] *= -1
    along[:, _ARC + _SIDE : 2 * _ARC + _SIDE] += rim[:, ::-1]
    return along


def _unit(count: int) -> Floats:
    return np.linspace(0.0, 1.0, count)


def _evenly(pixel: Floats) -> tuple[Floats, Floats]:
    """Return points evenly along closed outlines, and the directions across them."""
    closed = np.concatenate([pixel, pixel[:, :1]], axis=1)
    chord = np.diff(closed, axis=1)
    length = np.hypot(chord[..., 0], chord[..., 1])
    whole = np.isfinite(length).all(axis=1)
    contour = np.full((len(pixel), POINTS, 2), np.nan)
    normal = np.full((len(pixel), POINTS), np.nan)
    share = (np.arange(POINTS) + 0.5) / POINTS
    for row in np.flatnonzero(whole).tolist():
        along = np.append(0.0, np.cumsum(length[row]))
        at = share * along[-1]
        segment = np.clip(np.searchsorted(along, at, side='right') - 1, 0, length.shape[1] - 1)
        rest = (at - along[segment]) / np.maximum(length[row, segment], 1e-9)
        contour[row] = closed[row, segment] + rest[:, None] * chord[row, segment]
        tangent = chord[row, segment]
        normal[row] = np.mod(np.arctan2(tangent[:, 0], -tangent[:, 1]), np.pi)
    return contour, normal
