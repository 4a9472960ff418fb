"""Exact truth in the rows that trackers publish."""

from __future__ import annotations

import numpy as np

from mctrack_ros.interfaces import ClassCode, Detections, Tracks, TrackStatus
from mctrack_ros.simulation.intent import PLAYERS
from mctrack_ros.simulation.sight import View
from mctrack_ros.simulation.world import World


def true_tracks(world: World, step: int) -> Tracks:
    """Return everybody's ground position, velocity and id at a step."""
    motion = world.motion
    height = world.appearance.height
    return Tracks.build(
        world.scenario.stamp_ns(step),
        position=np.column_stack([motion.position[step], np.zeros(PLAYERS)]),
        velocity=motion.velocity[step],
        extent=np.column_stack([0.3 * height, height]),
        age=np.full(PLAYERS, (step + 0.5) * world.scenario.period_s),
        track_id=world.ids,
        status=np.full(PLAYERS, TrackStatus.CONFIRMED),
        class_id=np.full(PLAYERS, ClassCode.PERSON),
        kit=world.appearance.kit,
    )


def true_detections(world: World, step: int, view: View) -> Detections:
    """
    Return the people in a camera's picture, by id.

    ``box`` is that of the person drawn alone, ``area`` its pixels, ``score`` the share of them
    that nobody in front hides, ``position`` the true place on the ground.
    """
    order = np.argsort(view.person, kind='stable')
    person = view.person[order]
    return Detections.build(
        world.scenario.stamp_ns(step),
        position=np.column_stack([world.motion.position[step, person], np.zeros(len(person))]),
        box=view.box[order],
        area=view.pixels[order],
        score=view.visible[order],
        track_id=world.ids[person],
        truncated=view.truncated[order],
        class_id=np.full(len(person), ClassCode.PERSON),
        kit=world.appearance.kit[person],
    )
