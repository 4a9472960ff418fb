"""What a camera truly sees: everybody's silhouette, from far to near, and who hides whom."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.rendering.bodies import CLOTH, Pose, outlines, posed
from mctrack_ros.simulation.rendering.silhouettes import Silhouette, drawn_alone, touching_pairs
from mctrack_ros.simulation.world import World

Layers = list[tuple[int, Silhouette]]

_SUN = np.array([0.75, 0.5])
"""Shadow of something 1 m high, m."""


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """
    What one camera truly sees at one step, one row a person in the image, far ones first.

    Attributes
    ----------
    person : (n,) int array
        Index of the person.
    box : (n, 4) array
        Left, top, width and height of the person drawn alone, cut at the image's edge, px.
    pixels : (n,) int array
        Pixels of the person drawn alone.
    visible : (n,) array
        Share of them that nobody in front hides.
    truncated : (n,) bool array
        Whether the image's edge cuts the person.
    touching : (pairs, 2) int array
        Rows of people whose silhouettes overlap or touch.

    """

    person: NDArray[np.int64]
    box: NDArray[np.float64]
    pixels: NDArray[np.int64]
    visible: NDArray[np.float64]
    truncated: NDArray[np.bool_]
    touching: NDArray[np.int64]

    @staticmethod
    def of(layers: Layers, owner: NDArray[np.uint16]) -> View:
        """Return what is seen of silhouettes laid over one another, given who owns each pixel."""
        pixels = np.array([np.count_nonzero(shape.cloth) for _, shape in layers], np.int64)
        left = [np.count_nonzero(owner[shape.window] == person + 1) for person, shape in layers]
        return View(
            person=np.array([person for person, _ in layers], np.int64),
            box=np.array([shape.box for _, shape in layers], np.float64).reshape(-1, 4),
            pixels=pixels,
            visible=np.array(left, np.float64) / np.maximum(pixels, 1),
            truncated=np.array([shape.truncated for _, shape in layers], np.bool_),
            touching=touching_pairs([shape for _, shape in layers]),
        )


def owners(layers: Layers, size: tuple[int, int]) -> NDArray[np.uint16]:
    """Return whom each pixel of an image of a size shows, (height, width): index + 1, or 0."""
    owner = np.zeros(size[::-1], np.uint16)
    for person, shape in layers:
        np.copyto(owner[shape.window], person + 1, where=shape.cloth > 0)
    return owner


class Sight:
    """
    One camera's silhouettes and truth, without the image.

    Parameters
    ----------
    world : World
        The match.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: World, camera_index: int) -> None:
        self._world, self._camera = world, world.cameras[camera_index]

    def layers(self, step: int) -> Layers:
        """Return everybody in the image, index and silhouette drawn alone, far ones first."""
        return self._drawn(self._pose(step), self._camera.at(step))

    def shadows(self, step: int, sun: NDArray[np.float64] = _SUN) -> Layers:
        """Return everybody's shadow on the ground, given that of something 1 m high, (2,) m."""
        pose = self._pose(step)
        ends = pose.ends.copy()
        ends[..., :2] += ends[..., 2:] * sun
        ends[..., 2] = 0
        return self._drawn(replace(pose, ends=ends), self._camera.at(step))

    def view(self, step: int) -> View:
        """Return what is truly seen at a step."""
        return self.view_of(self.layers(step))

    def view_of(self, layers: Layers) -> View:
        """Return what is truly seen of people laid over one another."""
        return View.of(layers, owners(layers, self._camera.at(0).size))

    def _pose(self, step: int) -> Pose:
        motion = self._world.motion
        speed = np.linalg.norm(motion.velocity[step], axis=1)
        return posed(
            motion.position[step],
            motion.heading[step],
            speed,
            motion.stride[step],
            self._world.appearance.height,
            self._camera.at(step).position,
        )

    @staticmethod
    def _drawn(pose: Pose, camera: Camera) -> Layers:
        corners, order = outlines(pose, camera)
        depth = camera.depth(pose.ends).mean(axis=(1, 2))
        low, high = corners.min(axis=(1, 2)), corners.max(axis=(1, 2))
        size = camera.size
        inside = (depth > 1) & (high > -1).all(axis=1) & (low < np.array(size) + 1).all(axis=1)
        layers = []
        for person in np.argsort(-depth, kind='stable').tolist():
            if inside[person]:
                shape = drawn_alone(corners[person], order[person], CLOTH, size)
                if shape is not None:
                    layers.append((person, shape))
        return layers
