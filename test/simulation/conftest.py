import dataclasses
import pickle

import numpy as np
import pytest

from mctrack_ros.simulation import Scenario, World
from mctrack_ros.simulation.carpark.rendering import render as carpark_render
from mctrack_ros.simulation.rendering import render

NOWHERE = (-500.0, -500.0)


def remembered(draw):
    """Let an empty scene be drawn once for each camera and state of random numbers."""
    drawn = {}

    def once(camera, rng):
        key = pickle.dumps((camera, rng.bit_generator.state))
        if key not in drawn:
            drawn[key] = draw(camera, rng), rng.bit_generator.state
        image, rng.bit_generator.state = drawn[key]
        return image.copy()

    return once


@pytest.fixture(scope='session', autouse=True)
def empty_scenes():
    """Draw no empty scene twice."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(render, 'empty_image', remembered(render.empty_image))
        patch.setattr(carpark_render, 'empty_ground', remembered(carpark_render.empty_ground))
        yield


@pytest.fixture
def staged():
    """Make a world in which only some people are near the pitch: index -> (steps, 2) places."""

    def stage(places, **options):
        paths = {person: np.atleast_2d(path) for person, path in places.items()}
        steps = max((len(path) for path in paths.values()), default=1)
        scenario = Scenario(**({'duration_s': steps / 25, 'noise': 1e-3} | options))
        world = World.simulated(scenario)
        position = np.broadcast_to(NOWHERE, world.motion.position.shape).copy()
        for person, path in paths.items():
            position[:, person] = path
        motion = dataclasses.replace(
            world.motion, position=position, velocity=np.zeros_like(position)
        )
        return World.of(scenario, motion)

    return stage
