"""The empty car park in grey: asphalt with stains and patches, painted bays, what is beyond."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark import layout
from mctrack_ros.simulation.carpark.rendering.looks import ASPHALT, GRASS, HEDGE, PAINT, PAVEMENT

Floats = NDArray[np.float64]

_SUBPIXELS = 3
_GRASS_Y, _HEDGE_Y = 31.5, 44.0
_GRAIN, _PATCHES, _STAINS = 1.5, 2.3, 40


def empty_ground(camera: Camera, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return what a camera sees of the ground: (height, width) grey levels."""
    width, height = camera.size
    offsets = (np.arange(_SUBPIXELS) + 0.5) / _SUBPIXELS
    columns = (np.arange(width)[:, None] + offsets).ravel()
    rows = (np.arange(height)[:, None] + offsets).ravel()
    place = camera.ground(np.stack(np.meshgrid(columns, rows), axis=-1))
    fine = _surface(place).reshape(height, _SUBPIXELS, width, _SUBPIXELS)
    image = fine.mean(axis=(1, 3)).astype(np.float32)
    return np.asarray(image + _wear(height, width, rng), np.float32)


def _surface(place: Floats) -> Floats:
    """Return the grey of (..., 2) places on the ground."""
    x, y = place[..., 0], place[..., 1]
    grey = np.where(layout.painted(x, y), PAINT, ASPHALT)
    walks = (y > layout.PAVEMENT_Y[0]) & (y < layout.PAVEMENT_Y[1])
    walks |= (y > layout.FOOTWAY_Y[0]) & (y < layout.FOOTWAY_Y[1])
    grey = np.where(walks, PAVEMENT, grey)
    grey = np.where((y > _GRASS_Y) | (y < layout.PAVEMENT_Y[0] - 1), GRASS, grey)
    return np.asarray(np.where(~(y < _HEDGE_Y), HEDGE, grey))


def _wear(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return static unevenness: grain, worn patches, oil stains."""
    grain = rng.normal(scale=_GRAIN, size=(height, width)).astype(np.float32)
    coarse = rng.normal(size=(height // 16 + 2, width // 32 + 2)).astype(np.float32)
    patches = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    stains = np.zeros((height, width), np.float32)
    for _ in range(_STAINS):
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        axes = (int(rng.integers(3, 14)), int(rng.integers(2, 5)))
        cv2.ellipse(stains, centre, axes, 0, 0, 360, float(rng.uniform(-7, -2)), -1)
    return np.asarray(grain + _PATCHES * patches + cv2.GaussianBlur(stains, (5, 5), 0), np.float32)
