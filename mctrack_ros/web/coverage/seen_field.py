"""The chosen camera's field of view, drawn in the camera's image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError
from mctrack_ros.web.coverage.corner_order import place_in_order
from mctrack_ros.web.coverage.fields import Fields

Floats = NDArray[np.float64]
_THERE_AND_BACK_PX = 2.0
"""How far the way to the ground and back may miss a pixel that shows ground."""
_ADVICE = 'nothing was changed: click lower in the image'


def mapping_of(fields: Fields) -> GroundMapping:
    """Return the mapping of the chosen camera."""
    mapping = fields.view.mapping
    if mapping is None:
        raise FieldOfViewError(f'{fields.chosen} is not calibrated: draw its field on the ground')
    return mapping


def seen_corners(fields: Fields) -> Floats:
    """Return where the chosen camera sees the corners of its field, (k, 2) px, NaN: it cannot."""
    corners = np.reshape(np.array(fields.corners, np.float64), (-1, 2))
    return mapping_of(fields).image_from_ground(corners)


def add_seen(fields: Fields, x: float, y: float) -> None:
    """
    Add a corner where the chosen camera sees it, px; its place in their order is found there.

    Raises
    ------
    FieldOfViewError
        If no ground within reach is seen there; the field stays as it is.

    """
    ground = ground_seen(mapping_of(fields), x, y, fields.reach)
    pixels, index = seen_corners(fields), None
    if np.isfinite(pixels).all():
        index = place_in_order([(u, v) for u, v in pixels.tolist()], (x, y))
    fields.add(*ground, index)


def move_seen(fields: Fields, index: int, x: float, y: float) -> None:
    """Put a corner elsewhere in the image, px; raises as `add_seen`."""
    fields.move(index, *ground_seen(mapping_of(fields), x, y, fields.reach))


def ground_seen(mapping: GroundMapping, x: float, y: float, reach: float) -> tuple[float, float]:
    """
    Return the ground position, m, that a pixel shows.

    Parameters
    ----------
    mapping : GroundMapping
        The camera.
    x, y : float
        Column and row, px.
    reach : float
        How far from the camera's foot a place may be, m.

    Raises
    ------
    FieldOfViewError
        If the pixel is outside the image, above the horizon, or shows a place beyond reach.

    """
    width, height = mapping.image_size
    if not (0 <= x <= width and 0 <= y <= height):
        raise FieldOfViewError(f'({x:.0f}, {y:.0f}) px is outside the image')
    pixel = np.array([[x, y]])
    ground = mapping.ground_from_image(pixel)
    off = np.hypot(*(mapping.image_from_ground(ground) - pixel)[0])
    if not off < _THERE_AND_BACK_PX:
        raise FieldOfViewError(
            f'({x:.0f}, {y:.0f}) px shows no ground, it is above the horizon; {_ADVICE}'
        )
    away = float(np.hypot(*(ground[0] - mapping.camera_position[:2])))
    if away > reach:
        raise FieldOfViewError(
            f'({x:.0f}, {y:.0f}) px shows the ground {away:.0f} m away, beyond the reach of '
            f'{reach:g} m; {_ADVICE}'
        )
    return float(ground[0, 0]), float(ground[0, 1])
