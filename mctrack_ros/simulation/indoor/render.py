"""Images of the room: cluttered walls, a tiled floor, people, light and noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.indoor.layout import CEILING_M, LENGTH_M, WALL_M, WIDTH_M
from mctrack_ros.simulation.rendering.light import brightness, gain
from mctrack_ros.simulation.rendering.noise import SensorNoise
from mctrack_ros.simulation.rendering.sight import Sight, View
from mctrack_ros.simulation.world import World

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

PX_PER_M = 160
_SUBPIXELS = 2
_DRIFT_S = 40.0
_BLUR_PX = 0.6
"""Of the lens: edges of people are no sharper than those of the room."""
_TILE_M = 0.6
_LOW = np.array([-WALL_M, -WALL_M, 0.0])
_HIGH = np.array([LENGTH_M + WALL_M, WIDTH_M + WALL_M, CEILING_M])


class IndoorRenderer:
    """
    Render one camera; any step, in any order, gives the same bytes.

    Parameters
    ----------
    world : World
        What goes on.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: World, camera_index: int) -> None:
        self._world = world
        self._sight = Sight(world, camera_index)
        self._empty = self.room(world.cameras[camera_index].at(0), world.scenario.seed)
        rng = np.random.default_rng([world.scenario.seed, 25, camera_index])
        self._noise = SensorNoise(world.scenario, self._empty.shape, camera_index, rng)

    @staticmethod
    def room(camera: Camera, seed: int) -> Image:
        """Return what a camera sees of the empty room, (height, width, 3)."""
        rng = np.random.default_rng([seed, 24])  # one room for all cameras
        return room_seen(camera, textures(_LOW, _HIGH, rng), _LOW, _HIGH)

    def empty(self, step: int) -> Image:
        """Return a copy of what is behind the people of a step, (height, width, 3)."""
        return self._empty.copy()

    def frame(self, step: int) -> tuple[Image, View]:
        """Return the (height, width, 3) image of a step, blue, green, red, and its truth."""
        scenario = self._world.scenario
        image = self.empty(step)
        layers = self._sight.layers(step)
        for person, shape in layers:
            mask = shape.cloth > 0
            image[shape.window][mask] = self._world.appearance.palette[person][shape.cloth[mask]]
        cv2.GaussianBlur(image, (0, 0), _BLUR_PX, image)
        cv2.convertScaleAbs(image, image, brightness(scenario, step, _DRIFT_S))
        self._noise.add(image, step)
        cv2.convertScaleAbs(image, image, gain(scenario, step))
        return image, self._sight.view_of(layers)


def room_seen(camera: Camera, surfaces: list[Image], low: Floats, high: Floats) -> Image:
    """Return what a camera sees of an empty room between two corners, m, (height, width, 3)."""
    width, height = camera.size
    ends = (np.arange(n * _SUBPIXELS) / _SUBPIXELS + 0.5 / _SUBPIXELS for n in (width, height))
    ray = _rays(camera, np.stack(np.meshgrid(*ends), axis=-1))
    with np.errstate(divide='ignore', invalid='ignore'):
        reach = np.where(ray > 0, high - camera.position, low - camera.position) / ray
    axis = np.argmin(np.where(np.isfinite(reach), reach, np.inf), axis=-1)
    place = camera.position + ray * np.take_along_axis(reach, axis[..., None], -1)
    image = np.full((*axis.shape, 3), 205, np.uint8)
    for side, texture in enumerate(surfaces):
        along, up = ((1, 2), (0, 2), (0, 1))[side // 2]
        shown = (axis == side // 2) & ((np.sign(ray[..., side // 2]) > 0) == bool(side % 2))
        x = ((place[..., along] - low[along]) * PX_PER_M).astype(np.float32)
        y = ((place[..., up] - low[up]) * PX_PER_M).astype(np.float32)
        seen = cv2.remap(texture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        image[shown] = seen[shown]
    return np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def _rays(camera: Camera, pixel: Floats) -> Floats:
    """Return the directions, (..., 3), of pixels; the lens undone as the camera does it."""
    seen = (pixel - camera.principal_point) / camera.focal_px
    straight = camera.undistorted(seen)
    return np.asarray(straight @ camera.rotation[:2] + camera.rotation[2])


def textures(low: Floats, high: Floats, rng: np.random.Generator) -> list[Image]:
    """Return the west, east, south and north wall, the floor and the ceiling."""
    size = np.round((high - low) * PX_PER_M).astype(int)
    walls = [_wall(size[1 - side // 2], size[2], rng) for side in range(4)]
    return [*walls, _floor(size[0], size[1], rng), np.full((size[1], size[0], 3), 225, np.uint8)]


def _wall(width: int, height: int, rng: np.random.Generator) -> Image:
    """Return a wall with cupboards, posters, shelves and cables, upwards."""
    wall = np.empty((height, width, 3), np.uint8)
    wall[:] = rng.integers(170, 215, 3)
    cv2.rectangle(wall, (0, 0), (width, 14), (90, 95, 100), -1)

    def pick(low: int, high: int) -> int:
        return int(rng.integers(low, high))

    def colour(low: int, high: int) -> list[int]:
        return [pick(low, high) for _ in range(3)]

    for _ in range(3):  # cupboards
        x, wide, tall = pick(0, width), pick(60, 150), pick(90, 300)
        cv2.rectangle(wall, (x, 0), (x + wide, tall), colour(60, 200), -1)
        for left in (x, x + wide // 2):
            cv2.rectangle(wall, (left + 3, 6), (left + wide // 2 - 3, tall - 4), (50, 50, 55), 2)
    for _ in range(6):  # posters, screens
        x, y = pick(0, width), pick(PX_PER_M // 2, height)
        wide, tall = pick(40, 140), pick(40, 120)
        cv2.rectangle(wall, (x, y), (x + wide, y + tall), colour(30, 240), -1)
        cv2.rectangle(wall, (x, y), (x + wide, y + tall), (40, 40, 40), 3)
        for line in range(y + 12, y + tall - 8, 12):
            cv2.line(wall, (x + 8, line), (x + wide - 8, line), colour(20, 240), 2)
    for _ in range(4):  # shelves of books
        x, y, wide = pick(0, width - 100), pick(30, 2 * PX_PER_M), pick(100, 260)
        cv2.rectangle(wall, (x, y), (x + wide, y + 52), (60, 70, 90), -1)
        at = x
        while at < x + wide - 4:
            thick, tall = pick(4, 12), pick(28, 46)
            cv2.rectangle(wall, (at, y + 6), (at + thick, y + 6 + tall), colour(20, 230), -1)
            at += thick + pick(0, 3)
    for _ in range(4):  # cables
        x = pick(0, width)
        cv2.line(wall, (x, 0), (x + pick(-9, 9), height), (70, 70, 75), 2)
    return wall


def _floor(width: int, height: int, rng: np.random.Generator) -> Image:
    """Return tiles of slightly different grey with joints, some furniture's feet, a carpet."""
    side = round(_TILE_M * PX_PER_M)
    rows, columns = height // side + 1, width // side + 1
    tiles = rng.integers(118, 136, (rows, columns)).astype(np.uint8)
    grey = np.kron(tiles, np.ones((side, side), np.uint8))[:height, :width]
    floor = np.stack([grey, grey, grey], axis=-1)
    floor[::side] = floor[:, ::side] = 92
    for _ in range(10):
        x, y = rng.integers(0, width), rng.integers(0, height)
        cv2.circle(floor, (int(x), int(y)), int(rng.integers(4, 14)), (70, 75, 80), -1)
    return np.ascontiguousarray(floor)
