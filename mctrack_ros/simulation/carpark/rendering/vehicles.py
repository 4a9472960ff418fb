"""Cars as boxes: body, cabin and wheels, whose faces are shaded by where they look."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera

Floats = NDArray[np.float64]


class Part(IntEnum):
    """What a pixel of a car is made of."""

    NOTHING = 0
    SKIRT = 1
    LIT_SIDE = 2
    SHADED_SIDE = 3
    TOP = 4
    ROOF = 5
    GLASS = 6
    WHEEL = 7
    LAMP = 8


_SUN = np.array([-0.85, -0.5])
"""Direction to the sun over the ground: faces that look there are lit."""

_SILL, _BELT = 0.18, 0.56
"""Heights of the body's lower edge and of the windows', of the car's height."""

_CABIN = np.array([(-0.42, -0.86), (0.20, -0.86), (0.20, 0.86), (-0.42, 0.86)])
_ROOF = np.array([(-0.34, -0.72), (0.06, -0.72), (0.06, 0.72), (-0.34, 0.72)])
"""Corners of the cabin at the belt and at the roof, in lengths and half widths."""

_BODY = np.array([(-0.5, -1.0), (0.5, -1.0), (0.5, 1.0), (-0.5, 1.0)])
_WHEELS = ((-0.32, -1.0), (0.31, -1.0), (0.31, 1.0), (-0.32, 1.0))
_WHEEL_M = 0.31


def car_faces(
    place: Floats, heading: float, size: Floats, camera: Camera
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """
    Project a car's faces.

    Parameters
    ----------
    place : (2,) array
        Its middle on the ground, m.
    heading : float
        Where its front looks, rad.
    size : (3,) array
        Length, width and height, m.
    camera : Camera
        Where it is seen from.

    Returns
    -------
    corners : (faces, 4, 2) array
        Corners of the faces, px.
    order : (faces,) int array
        Faces from far to near: those turned away first.
    part : (faces,) int array
        The `Part` that each is made of.

    """
    local, part = _faces(size)
    turned = rotated(local[..., :2], heading)
    world = np.concatenate([turned + place, local[..., 2:]], axis=2)
    normal = np.cross(world[:, 1] - world[:, 0], world[:, 3] - world[:, 0])
    seen = ((camera.position - world.mean(axis=1)) * normal).sum(axis=1) > 0
    lit = normal[:, :2] @ _SUN > 0.25 * np.linalg.norm(normal, axis=1)
    part = np.where((part == Part.LIT_SIDE) & ~lit, Part.SHADED_SIDE, part)
    return camera.project(world), np.argsort(seen, kind='stable'), part


def rotated(local: Floats, heading: Floats | float) -> Floats:
    """Return (..., 2) offsets, forward and left, turned by headings that broadcast, m."""
    cosine, sine = np.cos(heading), np.sin(heading)
    forward, left = local[..., :1], local[..., 1:]
    return np.concatenate(
        [cosine * forward - sine * left, sine * forward + cosine * left], axis=-1
    )


def footprint(place: Floats, heading: float, size: Floats) -> Floats:
    """Return the (4, 2) corners of a car on the ground, m."""
    return np.asarray(place + rotated(_BODY * [size[0], size[1] / 2], heading))


def _faces(size: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the (faces, 4, 3) corners in the car's frame, seen from outside anticlockwise."""
    scale = np.array([size[0], size[1] / 2])
    sill, belt, top = _SILL * size[2], _BELT * size[2], size[2]
    parts = (
        (Part.SKIRT, _ring(_BODY * scale, 0.06, _BODY * scale, sill)),
        (Part.LIT_SIDE, _ring(_BODY * scale, sill, _BODY * scale, belt)),
        (Part.LAMP, [_lamp(scale, side, sill, belt) for side in (-1, 1)]),
        (Part.WHEEL, [_wheel(np.array(spot) * scale) for spot in _WHEELS]),
        (Part.TOP, [_flat(_BODY * scale, belt)]),
        (Part.GLASS, _ring(_CABIN * scale, belt, _ROOF * scale, top)),
        (Part.ROOF, [_flat(_ROOF * scale, top)]),
    )
    faces = [face for _, some in parts for face in some]
    return np.array(faces), np.array([part for part, some in parts for _ in some], np.int64)


def _ring(low: Floats, low_z: float, high: Floats, high_z: float) -> list[Floats]:
    """Return the four faces between two rectangles."""
    faces = []
    for side in range(4):
        after = (side + 1) % 4
        ground, above = (
            [(*low[side], low_z), (*low[after], low_z)],
            [
                (*high[after], high_z),
                (*high[side], high_z),
            ],
        )
        faces.append(np.array(ground + above))
    return faces


def _flat(corners: Floats, height: float) -> Floats:
    return np.column_stack([corners, np.full(4, height)])


def _lamp(scale: Floats, end: int, low: float, high: float) -> Floats:
    """Return a strip across the front or the back in which the lamps are."""
    x, half = end * 0.5 * scale[0], 0.9 * scale[1]
    below, above = low + 0.45 * (high - low), low + 0.75 * (high - low)
    corners = [(x, -half, below), (x, half, below), (x, half, above), (x, -half, above)]
    return np.array(corners if end > 0 else [corners[i] for i in (1, 0, 3, 2)])


def _wheel(spot: Floats) -> Floats:
    """Return a wheel on the left or the right side."""
    x, y = spot
    corners = [(x - _WHEEL_M, y, 0.0), (x + _WHEEL_M, y, 0.0)]
    corners += [(x + 0.8 * _WHEEL_M, y, 0.55), (x - 0.8 * _WHEEL_M, y, 0.55)]
    return np.array(corners if y < 0 else [corners[i] for i in (1, 0, 3, 2)])


def shade_of(place: Floats, heading: float, size: Floats, sun: Floats) -> Floats:
    """Return the (quads, 4, 3) places on the ground that a car shades: below it and beside."""
    base = footprint(place, heading, size)
    belt = base + _BELT * size[2] * sun
    roof = place + rotated(_ROOF * [size[0], size[1] / 2], heading) + size[2] * sun
    flats = [base, belt, roof]
    for low, high in ((base, belt), (_cabin_base(place, heading, size, sun), roof)):
        flats += [
            np.array([low[side], low[side - 1], high[side - 1], high[side]]) for side in range(4)
        ]
    return np.stack([np.pad(flat, ((0, 0), (0, 1))) for flat in flats])


def _cabin_base(place: Floats, heading: float, size: Floats, sun: Floats) -> Floats:
    """Return where the shadow of the cabin begins."""
    corners = rotated(_CABIN * [size[0], size[1] / 2], heading)
    return np.asarray(place + corners + _BELT * size[2] * sun)
