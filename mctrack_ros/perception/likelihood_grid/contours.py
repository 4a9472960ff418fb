"""Outlines of upright cylinders in a camera's image, with normals (section 4.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping

Floats = NDArray[np.float64]

POINTS = 64
"""Points of an outline, evenly along it."""
_ARC, _SIDE = 24, 24
"""Points along a rim and along a side before they are spread evenly."""


def cylinder_contours(
    mapping: GroundMapping, position: Floats, height: float, radius: float
) -> tuple[Floats, Floats]:
    """
    Return the outlines of cylinders and their normals, the lens's distortion included.

    The outline is the image of the two lines along which rays graze the mantle, the half of the
    lower rim that faces the camera, and the half of the upper rim that does not if the camera is
    above it, else that which does.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    position : (n, 2) array
        Axes of the cylinders on the ground, m.
    height, radius : float
        Of the cylinders, m.

    Returns
    -------
    contour : (n, 64, 2) array
        px; NaN where a part is not to be seen by the camera, or it stands in the cylinder.
    normal : (n, 64) array
        Direction of the normal, rad, 0 to pi.

    """
    camera = mapping.camera_position
    away = position - camera[:2]
    distance = np.hypot(*away.T)
    with np.errstate(invalid='ignore'):
        graze = np.arccos(np.where(distance > radius, -radius / distance, np.nan))
    towards = np.arctan2(away[:, 1], away[:, 0])
    # angles about the axis, the camera lying at `towards` + pi: grazed at towards +- graze
    near = towards[:, None] + graze[:, None] + (2 * (np.pi - graze))[:, None] * _unit(_ARC)
    far = towards[:, None] + graze[:, None] - 2 * graze[:, None] * _unit(_ARC)
    rim = far if camera[2] > height else near
    turns = [
        near,
        np.repeat(near[:, -1:], _SIDE, 1),
        rim[:, ::-1],
        np.repeat(near[:, :1], _SIDE, 1),
    ]
    heights = [
        np.zeros(_ARC),
        height * _unit(_SIDE),
        np.full(_ARC, height),
        height * _unit(_SIDE)[::-1],
    ]
    turn, level = np.concatenate(turns, axis=1), np.concatenate(heights)
    place = position[:, None] + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    levels = np.tile(level, len(position))
    pixel = mapping.image_from_ground(place.reshape(-1, 2), levels).reshape(*turn.shape, 2)
    return _evenly(pixel)


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
