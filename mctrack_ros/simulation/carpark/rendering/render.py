"""Grey images of the car park: light, shadows, bodies, reflections and noise."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark import layout
from mctrack_ros.simulation.carpark.rendering.looks import (
    ASPHALT,
    GRASS,
    HEDGE,
    PAINT,
    PAVEMENT,
    SHADOW,
)
from mctrack_ros.simulation.carpark.rendering.sight import CarParkSight
from mctrack_ros.simulation.carpark.rendering.vehicles import Part
from mctrack_ros.simulation.carpark.world import CarParkWorld
from mctrack_ros.simulation.rendering.light import brightness, gain
from mctrack_ros.simulation.rendering.noise import SensorNoise
from mctrack_ros.simulation.rendering.sight import Layers, View, owners

Grey = NDArray[np.uint8]
Floats = NDArray[np.float32]

_DRIFT_S = 150.0
_REFLECTIVE, _REFLECTION_M, _REFLECTION, _REFLECTION_PX = 0.4, 3.2, 26.0, 7
_THRESHOLD, _PIECE_PX = 12, 20
_NONE: dict[int, list[int]] = {}
_OPENING = np.ones((3, 3), np.uint8)
_SUBPIXELS = 3
_GRASS_Y, _HEDGE_Y = 31.5, 44.0
_GRAIN, _PATCHES, _STAINS = 1.5, 2.3, 40


@dataclass(frozen=True, eq=False, slots=True)
class CarParkView(View):
    """
    What is truly seen, and how well.

    Attributes
    ----------
    contrast : (n,) array
        Mean absolute difference between visible pixels and what is behind, grey levels.
    pieces : (n,) int array
        Pieces of at least 20 px into which an ideal difference mask (T = 12, no noise, opened)
        falls within the visible pixels.

    """

    contrast: NDArray[np.float64]
    pieces: NDArray[np.int64]


class CarParkRenderer:
    """
    Render the camera; any step, in any order, gives the same bytes.

    Parameters
    ----------
    world : CarParkWorld
        What goes on.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: CarParkWorld, camera_index: int) -> None:
        self._world = world
        self._sight = CarParkSight(world, camera_index)
        scenario = world.scenario
        rng = np.random.default_rng([scenario.seed, 4, camera_index])
        self._empty = empty_ground(world.cameras[camera_index].at(0), rng)
        self._noise = SensorNoise(scenario, self._empty.shape, camera_index, rng)
        self._reflects = rng.random(len(world.ids)) < _REFLECTIVE

    def frame(self, step: int) -> tuple[Grey, CarParkView]:
        """Return the (height, width) image of a step and its truth."""
        layers, shadows = self._sight.layers(step)
        parked = self._world.parked[step]
        image = self._composed(layers, shadows)
        behind = self._composed(_only(layers, parked), _only(shadows, parked))
        view = self._view(layers, image, behind, step)
        image = self._composed(layers, shadows, self._reflections(layers, step))
        scenario = self._world.scenario
        image *= brightness(scenario, step, _DRIFT_S)
        grey = np.clip(np.round(image), 0, 255).astype(np.uint8)
        self._noise.add(grey, step)
        amplified = gain(scenario, step)
        if amplified != 1.0:
            cv2.convertScaleAbs(grey, grey, amplified)
        return grey, view

    def _composed(
        self, layers: Layers, shadows: Layers, reflections: dict[int, list[int]] = _NONE
    ) -> Floats:
        """Lay shadows and bodies over the empty ground; brighten columns of windows."""
        image = self._empty.copy()
        if self._world.scenario.shadows:
            shade = np.zeros(image.shape, np.uint8)
            for _, shape in shadows:
                shade[shape.window] |= shape.cloth
            image[shade > 0] *= SHADOW
        for index, shape in layers:
            mask = shape.cloth > 0
            grey = self._world.appearance.palette[index].astype(np.float32)
            patch = image[shape.window]
            patch[mask] = grey[shape.cloth[mask]]
            for column in reflections.get(index, []):
                near = np.abs(np.arange(patch.shape[1]) - (column - shape.left)) < _REFLECTION_PX
                patch[(shape.cloth == Part.GLASS) & near] += _REFLECTION
        return image

    def _reflections(self, layers: Layers, step: int) -> dict[int, list[int]]:
        """Return in which columns of whose windows people who pass are mirrored (section 6)."""
        place, kind = self._world.motion.position[step], self._world.class_id
        walkers = [row for row in layers if kind[row[0]] == ClassCode.PERSON]
        columns: dict[int, list[int]] = {}
        for car in np.flatnonzero(self._reflects & self._world.parked[step]).tolist():
            for walker, body in walkers:
                if np.linalg.norm(place[walker] - place[car]) < _REFLECTION_M:
                    columns.setdefault(car, []).append(body.left + body.cloth.shape[1] // 2)
        return columns

    def _view(self, layers: Layers, image: Floats, behind: Floats, step: int) -> CarParkView:
        """Return the truth of an image; touching are only those who are active."""
        owner = owners(layers, (image.shape[1], image.shape[0]))
        active = self._world.active[step]
        seen, moving = View.of(layers, owner), View.of(_only(layers, active), owner)
        row_of = {person: row for row, person in enumerate(seen.person.tolist())}
        rows = np.array([row_of[person] for person in moving.person.tolist()], np.int64)
        difference = np.abs(image - behind)
        contrast, pieces = np.zeros(len(seen.person)), np.zeros(len(seen.person), np.int64)
        for index, shape in layers:
            if active[index]:
                own = owner[shape.window] == index + 1
                near = difference[shape.window]
                contrast[row_of[index]] = near[own].mean() if own.any() else 0.0
                pieces[row_of[index]] = _pieces((near > _THRESHOLD) & own)
        return CarParkView(
            person=seen.person,
            box=seen.box,
            pixels=seen.pixels,
            visible=seen.visible,
            truncated=seen.truncated,
            touching=rows[moving.touching],
            contrast=contrast,
            pieces=pieces,
        )


def _only(layers: Layers, who: NDArray[np.bool_]) -> Layers:
    """Return the layers of some of (n,)."""
    return [layer for layer in layers if who[layer[0]]]


def _pieces(mask: NDArray[np.bool_]) -> int:
    """Return how many 4-connected pieces an opened mask has that are large enough."""
    padded = np.pad(mask, 1).astype(np.uint8)
    opened = cv2.morphologyEx(padded, cv2.MORPH_OPEN, _OPENING)
    _, _, stats, _ = cv2.connectedComponentsWithStats(opened, connectivity=4)
    return int(np.count_nonzero(stats[1:, cv2.CC_STAT_AREA] >= _PIECE_PX))


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


def _surface(place: NDArray[np.float64]) -> NDArray[np.float64]:
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
