import dataclasses

import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception.moving_camera.moving_camera import CameraMotion, MovingCamera
from mctrack_ros.perception.moving_camera.turning_camera import TurningCamera
from mctrack_ros.simulation import PTZ, PtzScenario, painted_lines

SCENARIO = PtzScenario(seed=11, duration_s=6, cameras=1)
GROUND = np.stack(np.meshgrid(np.arange(2, 105, 4.0), np.arange(2, 68, 4.0)), -1).reshape(-1, 2)
PLACES = np.pad(GROUND, ((0, 0), (0, 1)))


@pytest.fixture(scope='module')
def panned():
    """Return a world, and the images and people of its camera."""
    world = PTZ.world(SCENARIO)
    renderer = PTZ.renderer(world, 0)
    return world, [renderer.frame(step) for step in range(SCENARIO.steps)]


def mapping_of(camera):
    return ProjectiveMapping(camera.matrix, camera.size)


def missed(camera, view):
    seen = camera.sees(PLACES)
    put = view.mapping.ground_from_image(camera.project(PLACES[seen]))
    return np.linalg.norm(put - GROUND[seen], axis=1)


def test_a_calibration_gives_its_camera_back(panned):
    world, _ = panned
    camera = world.views(40)[0]
    turning = TurningCamera.of(mapping_of(camera), 1e-3, 1e-3)
    np.testing.assert_allclose(turning.rotation, camera.rotation, atol=1e-6)
    np.testing.assert_allclose(turning.focal_px, camera.focal_px)
    back = turning.mapping().image_from_ground(GROUND[camera.sees(PLACES)])
    np.testing.assert_allclose(back, camera.project(PLACES[camera.sees(PLACES)]), atol=1e-6)


def test_slopes_are_those_of_the_projection(panned):
    turning = TurningCamera.of(mapping_of(panned[0].views(0)[0]), 1e-3, 1e-3)
    pixel = np.array([(100.0, 80.0), (700.0, 500.0), (300.0, 400.0)])
    rays, step = turning.rays(pixel), 1e-6
    np.testing.assert_allclose(turning.project(rays), pixel)
    for axis in range(4):
        moved = turning.moved(step * np.eye(4)[axis]).project(rays)
        np.testing.assert_allclose(
            (moved - pixel) / step, turning.slopes(pixel)[:, :, axis], rtol=1e-3, atol=0.1
        )


@pytest.mark.parametrize('lines', [(), painted_lines()], ids=['features', 'lines'])
def test_the_homography_follows_a_panning_camera(panned, lines):
    world, frames = panned
    moving = MovingCamera(mapping_of(world.views(0)[0]), lines)
    views = [moving.step(image, people.box) for image, people in frames]
    assert {view.state for view in views} == {CameraMotion.TRACKED}
    last = world.views(len(frames))[0]
    assert missed(last, views[-1]).max() < 0.5
    still = MovingCamera(mapping_of(world.views(0)[0])).step(frames[0][0])
    assert np.median(missed(last, still)) > 1


def test_lines_pull_a_wrong_calibration_back(panned):
    world, frames = panned
    right = TurningCamera.of(mapping_of(world.views(0)[0]), 1e-3, 1e-3)
    wrong = right.moved(np.array([8e-4, -8e-4, 0, 1e-3]))
    with_lines, without = (MovingCamera(wrong.mapping(), each) for each in (painted_lines(), ()))
    for step in range(50):
        image, people = frames[step]
        pulled, left = with_lines.step(image, people.box), without.step(image, people.box)
    camera = world.views(49)[0]
    assert np.median(missed(camera, pulled)) < 0.3 * np.median(missed(camera, left))


def test_a_dark_camera_is_lost_and_found_again(panned):
    world, frames = panned
    moving = MovingCamera(mapping_of(world.views(0)[0]), painted_lines())
    for step, (image, people) in enumerate(frames[:60]):
        dark = 20 <= step < 28
        view = moving.step(np.zeros_like(image) if dark else image, people.box)
        if dark:
            assert view.state is CameraMotion.LOST
            assert view.features == view.lines == 0
    assert view.state is CameraMotion.TRACKED
    assert np.median(missed(world.views(59)[0], view)) < 0.2


def test_the_noise_grows_while_nothing_is_found():
    camera = PTZ.cameras(dataclasses.replace(SCENARIO, duration_s=0.1))[0].at(0)
    moving, dark = MovingCamera(mapping_of(camera)), np.zeros(camera.size[::-1], np.uint8)
    noise = [moving.step(dark).noise_px for _ in range(5)]
    assert noise == sorted(noise)
    assert noise[-1] > 2 * noise[0]
