"""Noise of a sensor, the same for the same step."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.scenario import Scenario

_MARGIN = 96


class SensorNoise:
    """
    Gaussian noise: a window of a larger image of it, placed anew for each step.

    Parameters
    ----------
    scenario : Scenario
        Says how much, and the seed.
    shape : tuple of int
        Of the images: height, width and perhaps channels.
    camera_index : int
        Which of its cameras.
    rng : Generator
        Draws the noise.

    """

    def __init__(
        self,
        scenario: Scenario,
        shape: tuple[int, ...],
        camera_index: int,
        rng: np.random.Generator,
    ) -> None:
        self._seed = [scenario.seed, 5, camera_index]
        larger = (shape[0] + _MARGIN, shape[1] + _MARGIN, *shape[2:])
        noise = np.round(rng.normal(scale=scenario.noise, size=larger))
        self._brighter = np.clip(noise, 0, 255).astype(np.uint8)
        self._darker = np.clip(-noise, 0, 255).astype(np.uint8)

    def add(self, image: NDArray[np.uint8], step: int) -> None:
        """Add the noise of a step to an image, in place."""
        rng = np.random.default_rng([*self._seed, step])
        top, left = rng.integers(_MARGIN, size=2).tolist()
        height, width = image.shape[:2]
        window = (slice(top, top + height), slice(left, left + width))
        cv2.add(image, self._brighter[window], image)
        cv2.subtract(image, self._darker[window], image)
