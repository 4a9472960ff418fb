"""Images: people over the empty pitch, shadows, light and noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.pitch.stadium import empty_image, seat_crowd
from mctrack_ros.simulation.rendering.light import brightness, gain
from mctrack_ros.simulation.rendering.noise import SensorNoise
from mctrack_ros.simulation.rendering.sight import Layers, Sight, View
from mctrack_ros.simulation.world import World

Image = NDArray[np.uint8]

_SHADOW = 0.62
_DRIFT_S = 40.0


class CameraRenderer:
    """
    Render one camera; any step, in any order, gives the same bytes.

    Parameters
    ----------
    world : World
        The match.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: World, camera_index: int) -> None:
        self._world = world
        self._sight = Sight(world, camera_index)
        rng = np.random.default_rng([world.scenario.seed, 4, camera_index])
        self._camera = world.cameras[camera_index]
        self._empty = empty_image(self._camera.mosaic, rng)
        if self._is_moving:
            seat_crowd(self._empty, self._camera.mosaic, rng)
        width, height = self._camera.at(0).size
        self._noise = SensorNoise(world.scenario, (height, width, 3), camera_index, rng)

    def frame(self, step: int) -> tuple[Image, View]:
        """Return the (height, width, 3) image of a step, blue, green, red, and its truth."""
        scenario = self._world.scenario
        image = self._empty_at(step)
        if scenario.shadows:
            darken(image, self._sight.shadows(step))
        layers = self._sight.layers(step)
        for person, shape in layers:
            mask = shape.cloth > 0
            image[shape.window][mask] = self._world.appearance.palette[person][shape.cloth[mask]]
        _scale(image, brightness(scenario, step, _DRIFT_S))
        self._noise.add(image, step)
        _scale(image, gain(scenario, step))
        return image, self._sight.view_of(layers)

    def empty(self) -> Image:
        """Return the (height, width, 3) image without people that is taken after the match."""
        image = self._empty_at(self._world.scenario.steps)
        self._noise.add(image, self._world.scenario.steps)
        return image

    @property
    def _is_moving(self) -> bool:
        return self._camera.mosaic is not self._camera

    def _empty_at(self, step: int) -> Image:
        """Return what is seen of the empty pitch: one that turns cuts it out of a mosaic."""
        if not self._is_moving:
            return self._empty.copy()
        camera = self._camera.at(step)
        turned = camera.warp_from(self._camera.mosaic)
        return np.asarray(cv2.warpPerspective(self._empty, turned, camera.size), np.uint8)


def darken(image: Image, shadows: Layers, floor: NDArray[np.bool_] | None = None) -> None:
    """Darken the ground, or its part that is floor, where bodies keep the sun off; in place."""
    shade = np.zeros(image.shape[:2], np.uint8)
    for _, shape in shadows:
        shade[shape.window] |= shape.cloth
    dark = shade > 0 if floor is None else (shade > 0) & floor
    image[dark] = (image[dark] * _SHADOW).astype(np.uint8)


def _scale(image: Image, factor: float) -> None:
    """Make an image brighter, in place."""
    if factor != 1.0:
        cv2.convertScaleAbs(image, image, factor)
