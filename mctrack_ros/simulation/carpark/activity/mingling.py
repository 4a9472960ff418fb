"""Whether people of different activities come together in the image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark.activity.cast import Actor

Floats = NDArray[np.float64]

_BREADTH = 0.55
"""Of somebody's box with the shadow's nearest part, in heights."""


def people_meet(actors: list[Actor], others: list[Actor], camera: Camera) -> bool:
    """Return whether anybody's box in the image meets one of others' at some time."""
    mine, theirs = (
        [actor for actor in some if actor.class_id != ClassCode.VEHICLE]
        for some in (actors, others)
    )
    for one in mine:
        for other in theirs:
            first, last = max(one.first, other.first), min(one.last, other.last)
            if first < last and _meet(*(_boxes(who, first, last, camera) for who in (one, other))):
                return True
    return False


def _meet(one: Floats, other: Floats) -> bool:
    """Return whether (steps, 4) boxes, left, top, right and bottom, ever overlap."""
    apart = (one[:, :2] >= other[:, 2:]) | (other[:, :2] >= one[:, 2:])
    return bool((~apart.any(axis=1)).any())


def _boxes(person: Actor, first: int, last: int, camera: Camera) -> Floats:
    """Return where somebody is in the image, (steps, 4) px."""
    place = person.course.position[first - person.first : last - person.first]
    foot = np.pad(place, ((0, 0), (0, 1)))
    head = foot + np.array([0, 0, person.size[2]])
    low, high = camera.project(foot), camera.project(head)
    half = _BREADTH * (low[:, 1] - high[:, 1]) / 2
    return np.column_stack([low[:, 0] - half, high[:, 1], low[:, 0] + half, low[:, 1]])
