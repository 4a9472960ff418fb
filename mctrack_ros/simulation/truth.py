"""Exact truth in the rows that trackers publish."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.simulation.rendering.sight import View
from mctrack_ros.simulation.world import World


def true_tracks(world: World, step: int) -> Tracks:
    """Return ground position, velocity and id of all who are there to be tracked at a step."""
    return _tracks(world, step, world.active[step])


def parked_tracks(world: World, step: int) -> Tracks:
    """Return place and id of the cars that are parked at a step."""
    return _tracks(world, step, world.parked[step])


def _tracks(world: World, step: int, who: NDArray[np.bool_]) -> Tracks:
    motion = world.motion
    count = np.count_nonzero(who)
    since = world.active.argmax(axis=0)[who]
    return Tracks.build(
        world.scenario.stamp_ns(step),
        position=np.column_stack([motion.position[step, who], np.zeros(count)]),
        velocity=motion.velocity[step, who],
        extent=world.extent[who],
        age=(step - since + 0.5) * world.scenario.period_s,
        track_id=world.ids[who],
        status=np.full(count, TrackStatus.CONFIRMED),
        class_id=world.class_id[who],
        kit=world.appearance.kit[who],
    )


def true_detections(world: World, step: int, view: View) -> Detections:
    """
    Return those in a camera's image who are there to be tracked, by id.

    ``box`` is that of the person drawn alone, ``area`` its pixels, ``score`` the share of them
    that nobody in front hides, ``position`` the true place on the ground.
    """
    return _detections(world, step, view, world.active[step])


def parked_detections(world: World, step: int, view: View) -> Detections:
    """Return the parked cars in a camera's image, by id."""
    return _detections(world, step, view, world.parked[step])


def _detections(world: World, step: int, view: View, who: NDArray[np.bool_]) -> Detections:
    order = np.argsort(view.person, kind='stable')
    order = order[who[view.person[order]]]
    person = view.person[order]
    return Detections.build(
        world.scenario.stamp_ns(step),
        position=np.column_stack([world.motion.position[step, person], np.zeros(len(person))]),
        box=view.box[order],
        area=view.pixels[order],
        score=view.visible[order],
        extent=world.extent[person],
        track_id=world.ids[person],
        truncated=view.truncated[order],
        class_id=world.class_id[person],
        kit=world.appearance.kit[person],
    )
