"""What the camera truly sees of the car park: people, bicycles and cars, from far to near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark.rendering.bicycles import mounted
from mctrack_ros.simulation.carpark.rendering.order import far_first
from mctrack_ros.simulation.carpark.rendering.vehicles import car_faces, shade_of
from mctrack_ros.simulation.carpark.world import CarParkWorld
from mctrack_ros.simulation.rendering.bodies import CLOTH, Pose, outlines, posed
from mctrack_ros.simulation.rendering.sight import Layers
from mctrack_ros.simulation.rendering.silhouettes import Silhouette, drawn_alone

Floats = NDArray[np.float64]

_SUN = np.array([0.55, 0.35])
"""Shadow of something 1 m high, m."""

_MARGIN_PX = 150


class CarParkSight:
    """
    Silhouettes of all who are there.

    Parameters
    ----------
    world : CarParkWorld
        What goes on.
    camera_index : int
        Which of its cameras.

    """

    def __init__(self, world: CarParkWorld, camera_index: int) -> None:
        self._world, self._camera = world, world.cameras[camera_index].at(0)
        self._still: dict[tuple[int, bytes], tuple[Silhouette | None, Silhouette | None]] = {}

    def layers(self, step: int) -> tuple[Layers, Layers]:
        """Return everybody in the image, far ones first, and the shadows they throw."""
        bodies, shadows = {}, []
        for index, body, shadow in [*self._people(step), *self._riders(step), *self._cars(step)]:
            if body is not None:
                bodies[index] = body
            if shadow is not None:
                shadows.append((index, shadow))
        order = far_first(self._world, self._camera, step, bodies)
        return [(index, bodies[index]) for index in order], shadows

    def _near(self, step: int, kind: ClassCode) -> NDArray[np.int64]:
        """Return those of a class who are there and not far outside the image."""
        world = self._world
        index = np.flatnonzero(world.present[step] & (world.class_id == kind))
        place = np.pad(world.motion.position[step, index], ((0, 0), (0, 1)))
        pixel = self._camera.project(place)
        inside = (pixel > -_MARGIN_PX) & (pixel < np.array(self._camera.size) + _MARGIN_PX)
        return index[inside.all(axis=1) & (self._camera.depth(place) > 1)]

    def _people(self, step: int) -> list[tuple[int, Silhouette | None, Silhouette | None]]:
        motion, who = self._world.motion, self._near(step, ClassCode.PERSON)
        if len(who) == 0:
            return []
        pose = posed(
            motion.position[step, who],
            motion.heading[step, who],
            np.linalg.norm(motion.velocity[step, who], axis=1),
            motion.stride[step, who],
            self._world.appearance.height[who],
            self._camera.position,
        )
        return [
            (index, body, shadow)
            for index, (body, shadow) in zip(who.tolist(), self._with_shadow(pose, CLOTH))
        ]

    def _riders(self, step: int) -> list[tuple[int, Silhouette | None, Silhouette | None]]:
        motion, drawn = self._world.motion, []
        for index in self._near(step, ClassCode.BICYCLE).tolist():
            pose, part = mounted(
                motion.position[step, index],
                float(motion.heading[step, index]),
                float(motion.stride[step, index]),
                float(self._world.size[index, 2]),
            )
            ((body, shadow),) = self._with_shadow(pose, part)
            drawn.append((index, body, shadow))
        return drawn

    def _with_shadow(
        self, pose: Pose, part: NDArray[np.int64]
    ) -> list[tuple[Silhouette | None, Silhouette | None]]:
        """Draw everybody of a pose, and the shadow that he throws."""
        flat = pose.ends.copy()
        flat[..., :2] += flat[..., 2:] * _SUN
        flat[..., 2] = 0
        bodies, shadows = (
            [
                drawn_alone(*row, part, self._camera.size)
                for row in zip(*outlines(shape, self._camera))
            ]
            for shape in (pose, Pose(flat, pose.width))
        )
        return list(zip(bodies, shadows))

    def _cars(self, step: int) -> list[tuple[int, Silhouette | None, Silhouette | None]]:
        """Draw cars; what stands still is drawn once."""
        motion, drawn = self._world.motion, []
        for index in self._near(step, ClassCode.VEHICLE).tolist():
            place, heading = motion.position[step, index], float(motion.heading[step, index])
            key = (index, place.tobytes())
            if key not in self._still:
                self._still = {old: kept for old, kept in self._still.items() if old[0] != index}
                self._still[key] = self._car(place, heading, self._world.size[index])
            drawn.append((index, *self._still[key]))
        return drawn

    def _car(
        self, place: Floats, heading: float, size: Floats
    ) -> tuple[Silhouette | None, Silhouette | None]:
        corners, order, part = car_faces(place, heading, size, self._camera)
        body = drawn_alone(corners, order, part, self._camera.size)
        shade = self._camera.project(shade_of(place, heading, size, _SUN))
        one = np.zeros(len(shade), np.int64) + 1
        return body, drawn_alone(shade, np.arange(len(shade)), one, self._camera.size)
