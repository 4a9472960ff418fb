"""The empty image of a camera: mown grass, painted lines, what lies around the pitch."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.pitch import field as pitch

Floats = NDArray[np.float64]

_SUBPIXELS = 5
_LIGHT, _DARK, _VERGE = (62.0, 146.0, 92.0), (52.0, 126.0, 78.0), (46.0, 104.0, 66.0)
_PAINT, _TRACK, _STAND = (222.0, 230.0, 226.0), (72.0, 84.0, 148.0), (104.0, 104.0, 108.0)
_VERGE_M, _TRACK_M = 5.0, 12.0
_GRAIN, _PATCHES = 2.5, 5.0
_CROWD, _SEAT_PX = 45.0, 6


def empty_image(camera: Camera, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return what a camera sees of the empty pitch: (height, width, 3) blue, green, red."""
    width, height = camera.size
    columns, rows = np.arange(width + 1.0), np.arange(height + 1.0)
    corners = camera.ground(np.stack(np.meshgrid(columns, rows), axis=-1))
    colour = _surface(corners)
    image = colour[:-1, :-1].copy()
    mixed = _mixed(corners, colour)
    offsets = (np.arange(_SUBPIXELS) + 0.5) / _SUBPIXELS
    inside = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    pixel = np.argwhere(mixed)[:, None, ::-1] + inside
    image[mixed] = _surface(camera.ground(pixel)).mean(axis=1)
    image += _texture(height, width, rng)[..., None]
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def seat_crowd(image: NDArray[np.uint8], camera: Camera, rng: np.random.Generator) -> None:
    """Fill the stands of an empty image with a crowd, in place: texture that stays where it is."""
    width, height = camera.size
    middles = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    ground = camera.ground(middles)
    stands = ~(pitch.beyond_edge(ground[..., 0], ground[..., 1]) <= _TRACK_M)
    seats = rng.uniform(-_CROWD, _CROWD, (height // _SEAT_PX + 1, width // _SEAT_PX + 1, 3))
    crowd = cv2.resize(seats, None, fx=_SEAT_PX, fy=_SEAT_PX, interpolation=cv2.INTER_NEAREST)
    crowd = cv2.GaussianBlur(crowd[:height, :width], (0, 0), _SEAT_PX / 4)
    image[stands] = np.clip(np.round(image[stands] + crowd[stands]), 0, 255).astype(np.uint8)


def _mixed(corners: Floats, colour: Floats) -> NDArray[np.bool_]:
    """Return the (height, width) pixels that may hold more than one colour."""
    across = np.linalg.norm(corners[1:, 1:] - corners[:-1, :-1], axis=2)
    nearest = pitch.line_distance(corners[:-1, :-1, 0], corners[:-1, :-1, 1])
    mixed = nearest <= across + pitch.LINE_WIDTH_M / 2
    for other in (colour[1:, :-1], colour[:-1, 1:], colour[1:, 1:]):
        mixed |= (other != colour[:-1, :-1]).any(axis=2)
    return np.asarray(mixed)


def _surface(ground: Floats) -> Floats:
    """Return the (..., 3) colour of (..., 2) places on the ground."""
    x, y = ground[..., 0], ground[..., 1]
    outside = pitch.beyond_edge(x, y)
    colour = np.where(pitch.is_light_stripe(x)[..., None], _LIGHT, _DARK)
    colour = np.where(outside[..., None] > 0.5, _VERGE, colour)
    painted = pitch.line_distance(x, y) <= pitch.LINE_WIDTH_M / 2
    colour = np.where(painted[..., None], _PAINT, colour)
    colour = np.where(outside[..., None] > _VERGE_M, _TRACK, colour)
    beyond = ~(outside <= _TRACK_M)
    return np.where(beyond[..., None], _STAND, colour)


def _texture(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return static unevenness, (height, width) grey levels: grain of blades and worn patches."""
    grain = rng.normal(scale=_GRAIN, size=(height, width)).astype(np.float32)
    coarse = rng.normal(size=(height // 24 + 2, width // 48 + 2)).astype(np.float32)
    patches = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    return np.asarray(cv2.GaussianBlur(grain, (3, 3), 0.6) + _PATCHES * patches, np.float32)
