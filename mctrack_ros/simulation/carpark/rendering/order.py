"""Order of drawing, far to near: exact for upright people and the rectangles of cars."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark.rendering.vehicles import footprint
from mctrack_ros.simulation.carpark.world import CarParkWorld
from mctrack_ros.simulation.rendering.silhouettes import Silhouette

Floats = NDArray[np.float64]


def far_first(
    world: CarParkWorld, camera: Camera, step: int, bodies: dict[int, Silhouette]
) -> list[int]:
    """
    Return indices in the order in which bodies must be drawn so that near ones hide far ones.

    Of two whose boxes in the image meet, the one on the camera's side of a line that parts
    their places on the ground is nearer. Two convex places always have such a line.
    """
    who = np.array(sorted(bodies), np.int64)
    place = world.motion.position[step, who]
    depth = camera.depth(np.pad(place, ((0, 0), (0, 1))))
    who = who[np.argsort(-depth, kind='stable')]
    boxes = np.array([bodies[index].box for index in who.tolist()]).reshape(-1, 4)
    low, high = boxes[:, :2], boxes[:, :2] + boxes[:, 2:]
    meet = ((low[:, None] < high[None]) & (low[None] < high[:, None])).all(axis=2)
    hulls = [_hull(world, step, index) for index in who.tolist()]
    after: list[list[int]] = [[] for _ in who]
    for one, other in np.argwhere(np.triu(meet, 1)).tolist():
        if _is_nearer(hulls[one], hulls[other], camera.position[:2]):
            after[one].append(other)
        else:
            after[other].append(one)
    return [int(who[row]) for row in _sorted(after)]


def _sorted(before: list[list[int]]) -> list[int]:
    """Return rows so that each comes after those it lists, else in their own order."""
    done: list[int] = []
    state = [0] * len(before)

    def visit(row: int) -> None:
        if state[row] == 0:
            state[row] = 1
            for earlier in before[row]:
                visit(earlier)
            done.append(row)

    for row in range(len(before)):
        visit(row)
    return done


def _hull(world: CarParkWorld, step: int, index: int) -> Floats:
    """Return a car's (4, 2) corners or a person's (1, 2) place on the ground, m."""
    place = world.motion.position[step, index]
    if world.class_id[index] != ClassCode.VEHICLE:
        return np.asarray(place[None])
    return footprint(place, float(world.motion.heading[step, index]), world.size[index])


def _is_nearer(one: Floats, other: Floats, eye: Floats) -> bool:
    """Return whether one place is before another as seen from (2,) above the ground."""
    for hull, rest, turned in ((one, other, False), (other, one, True)):
        if len(hull) == 1:
            continue
        edge = np.roll(hull, -1, axis=0) - hull
        normal = np.column_stack([edge[:, 1], -edge[:, 0]])
        reach = ((rest[None] - hull[:, None]) * normal[:, None]).sum(axis=2).min(axis=1)
        best = int((reach / np.linalg.norm(normal, axis=1)).argmax())
        if reach[best] > 0 or len(rest) == 1:
            beyond = ((eye - hull[best]) * normal[best]).sum() > 0
            return bool(beyond == turned)
    return bool(np.linalg.norm(one.mean(axis=0) - eye) < np.linalg.norm(other.mean(axis=0) - eye))
