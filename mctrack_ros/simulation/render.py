"""Pictures: people over the empty pitch, shadows, light and noise, with what is truly seen."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.bodies import CLOTH, Pose, outlines, posed
from mctrack_ros.simulation.silhouettes import Silhouette, drawn_alone, touch
from mctrack_ros.simulation.stadium import empty_picture
from mctrack_ros.simulation.world import World

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

_NOISE_MARGIN = 96
_SHADOW = 0.62
_SUN = np.array([0.75, 0.5])
_DRIFT_S = 40.0


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """
    What one camera truly sees at one step, one row a person in the picture.

    Attributes
    ----------
    person : (n,) int array
        Index of the person.
    box : (n, 4) array
        Left, top, width and height of the person drawn alone, cut at the picture's edge, px.
    pixels : (n,) int array
        Pixels of the person drawn alone.
    visible : (n,) array
        Share of them that nobody in front hides.
    truncated : (n,) bool array
        Whether the picture's edge cuts the person.
    touching : (pairs, 2) int array
        Rows of people whose silhouettes overlap or touch.

    """

    person: NDArray[np.int64]
    box: Floats
    pixels: NDArray[np.int64]
    visible: Floats
    truncated: NDArray[np.bool_]
    touching: NDArray[np.int64]


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
        self._world, self._index = world, camera_index
        self._camera = world.cameras[camera_index]
        rng = np.random.default_rng([world.scenario.seed, 4, camera_index])
        self._empty = empty_picture(self._camera, rng)
        height, width = self._empty.shape[:2]
        shape = (height + _NOISE_MARGIN, width + _NOISE_MARGIN, 3)
        noise = np.round(rng.normal(scale=world.scenario.noise, size=shape))
        self._brighter = np.maximum(noise, 0).astype(np.uint8)
        self._darker = np.maximum(-noise, 0).astype(np.uint8)

    def frame(self, step: int) -> tuple[Image, View]:
        """Return the (height, width, 3) picture of a step, blue, green, red, and its truth."""
        scenario = self._world.scenario
        image = self._empty.copy()
        pose = self._pose(step)
        if scenario.shadows:
            self._draw_shadows(image, pose)
        silhouettes = self._silhouettes(pose)
        view = self._draw(image, silhouettes)
        if scenario.lighting_drift:
            turn = 2 * np.pi * (step + 0.5) * scenario.period_s / _DRIFT_S
            cv2.convertScaleAbs(image, image, 1 + scenario.lighting_drift * np.sin(turn))
        self._add_noise(image, step)
        return image, view

    def view(self, step: int) -> View:
        """Return what is truly seen, without making the picture."""
        return self._draw(None, self._silhouettes(self._pose(step)))

    def _pose(self, step: int) -> Pose:
        motion = self._world.motion
        speed = np.linalg.norm(motion.velocity[step], axis=1)
        return posed(
            motion.position[step],
            motion.heading[step],
            speed,
            motion.stride[step],
            self._world.appearance.height,
            self._camera.position,
        )

    def _silhouettes(self, pose: Pose) -> list[tuple[int, Silhouette]]:
        """Draw everybody alone; return them from far to near."""
        corners, order = outlines(pose, self._camera)
        depth = self._camera.depth(pose.ends).mean(axis=(1, 2))
        drawn = []
        for person in np.argsort(-depth, kind='stable').tolist():
            if depth[person] > 1:
                size = self._camera.size
                shape = drawn_alone(corners[person], order[person], CLOTH, size)
                if shape is not None:
                    drawn.append((person, shape))
        return drawn

    def _draw(self, image: Image | None, drawn: list[tuple[int, Silhouette]]) -> View:
        """Lay people over one another, far ones first; count what stays visible."""
        owner = np.zeros(self._camera.size[::-1], np.uint8)
        for person, shape in drawn:
            mask = shape.cloth > 0
            owner[shape.window][mask] = person + 1
            if image is not None:
                colours = self._world.appearance.palette[person][shape.cloth[mask]]
                image[shape.window][mask] = colours
        pixels = np.array([np.count_nonzero(shape.cloth) for _, shape in drawn], np.int64)
        left = [np.count_nonzero(owner[shape.window] == person + 1) for person, shape in drawn]
        pairs = [
            (one, other)
            for one in range(len(drawn))
            for other in range(one + 1, len(drawn))
            if touch(drawn[one][1], drawn[other][1])
        ]
        return View(
            person=np.array([person for person, _ in drawn], np.int64),
            box=np.array([shape.box for _, shape in drawn], np.float64).reshape(-1, 4),
            pixels=pixels,
            visible=np.array(left, np.float64) / np.maximum(pixels, 1),
            truncated=np.array([shape.truncated for _, shape in drawn], np.bool_),
            touching=np.array(pairs, np.int64).reshape(-1, 2),
        )

    def _draw_shadows(self, image: Image, pose: Pose) -> None:
        """Darken the ground where bodies keep the sun off."""
        ends = pose.ends.copy()
        ends[..., :2] += ends[..., 2:] * _SUN
        ends[..., 2] = 0
        shade = np.zeros(self._camera.size[::-1], np.uint8)
        for _, shape in self._silhouettes(Pose(ends, pose.width)):
            shade[shape.window] |= shape.cloth
        image[shade > 0] = (image[shade > 0] * _SHADOW).astype(np.uint8)

    def _add_noise(self, image: Image, step: int) -> None:
        rng = np.random.default_rng([self._world.scenario.seed, 5, self._index, step])
        top, left = rng.integers(_NOISE_MARGIN, size=2).tolist()
        height, width = image.shape[:2]
        window = (slice(top, top + height), slice(left, left + width))
        cv2.add(image, self._brighter[window], image)
        cv2.subtract(image, self._darker[window], image)
