"""Belief propagation by cameras that pan, tilt and zoom."""

import numpy as np
import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.pipeline import BeliefTracker
from mctrack_ros.fusion.inputs import BeliefInput
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief, CameraRows, Detections, RowsTick
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.pipeline import BeliefCamera
from mctrack_ros.simulation import PTZ, PtzScenario, painted_lines

SCENARIO = PtzScenario(seed=4, duration_s=4)
DARK_STEPS = range(40, 44)


@pytest.fixture(scope='module')
def filmed():
    """Return a world and the images of its cameras."""
    world = PTZ.world(SCENARIO)
    renderers = [PTZ.renderer(world, index) for index in range(2)]
    images = [[each.frame(step)[0] for step in range(SCENARIO.steps)] for each in renderers]
    return world, images


def mapping_of(camera):
    return ProjectiveMapping(camera.matrix, camera.size)


def followed(world, images, moving):
    """Return the last tracks of players who are in both views at first, and who these are."""
    views = world.views(0)
    cameras = {
        f'cam{index + 1}': BeliefCamera(
            BeliefCameraConfig(moving=moving, local_tracker='belief'),
            f'cam{index + 1}',
            mapping_of(view),
            lines=painted_lines(),
        )
        for index, view in enumerate(views)
    }
    tracker = BeliefTracker(BeliefConfig(start=False), tuple(cameras))
    place = world.motion.position
    ends = [world.views(step)[:] for step in (0, SCENARIO.steps - 1)]
    inside = np.ones(place.shape[1], bool)
    for step, seen in zip((0, SCENARIO.steps - 1), ends):
        for camera in seen:
            inside &= camera.sees(np.pad(place[step], ((0, 0), (0, 1))))
    who = np.flatnonzero(inside)[:4]
    start = Detections.build(
        SCENARIO.stamp_ns(0), position=np.pad(place[0, who], ((0, 0), (0, 1)))
    )
    tracker.start(start)
    for step in range(SCENARIO.steps):
        stamp_ns = SCENARIO.stamp_ns(step)
        messages = []
        for (name, camera), own in zip(cameras.items(), images):
            image = np.zeros_like(own[step]) if step in DARK_STEPS else own[step]
            told = tracker.feedback() if step else None
            parts = camera.step(image, stamp_ns, told).messages
            sighting = BeliefInput(parts[Detections.TOPIC], parts[Belief.TOPIC])
            messages.append(CameraRows(name, sighting))
        output = tracker.step(RowsTick.of(messages))
    return output.tracks, place[-1, who]


def test_players_are_followed_by_cameras_that_turn_and_were_dark(filmed):
    tracks, truth = followed(*filmed, moving=True)
    assert len(truth) == 4
    assert len(tracks) == 4
    gap = np.linalg.norm(tracks.position[:, :2] - truth, axis=1)
    assert np.median(gap) < 0.5
    assert (gap < 1.0).sum() >= 3


def test_a_camera_that_moves_must_be_a_pinhole_of_known_pose():
    with pytest.raises(ConfigError, match=r'pipeline\.moving'):
        BeliefCamera(BeliefCameraConfig(moving=True), 'cam1', object())
