"""The room of the likelihood-grid paper."""

import numpy as np
import pytest

from mctrack_ros.ground import mapping_from_grid
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import INDOOR, IndoorScenario
from mctrack_ros.simulation.calibration import camera_grid
from mctrack_ros.simulation.indoor.scenario import EMPTY_STEPS
from mctrack_ros.site.site import load_site


@pytest.mark.parametrize('seed', [1, 2])
def test_people_come_one_by_one_stay_close_and_never_stand_in_one_another(seed):
    world = INDOOR.world(IndoorScenario(seed=seed, people=5))
    assert not world.active[:EMPTY_STEPS].any()
    assert world.active[-1].all()
    figures = INDOOR.meter(world).result().figures()
    assert figures['close_share'] > 0.5
    assert figures['least_distance_m'] > 0.35
    speed = np.linalg.norm(world.motion.velocity[world.active], axis=1)
    assert speed.max() < 4


def test_they_change_places():
    place = INDOOR.world(IndoorScenario(seed=3, people=2)).motion.position[200:]
    apart = place[:, 0] - place[:, 1]
    angle = np.unwrap(np.arctan2(apart[:, 1], apart[:, 0]))
    assert np.ptp(angle) > np.pi


def test_a_seed_gives_the_same_images_and_another_does_not():
    first, same, other = (
        INDOOR.renderer(INDOOR.world(IndoorScenario(seed=seed)), 2).frame(300)[0]
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, same)
    assert (first != other).mean() > 0.5
    assert first.shape == (480, 752, 3)


def test_feet_are_where_the_calibration_says():
    scenario = IndoorScenario(seed=1)
    world = INDOOR.world(scenario)
    for index, camera in enumerate(world.cameras):
        mapping = mapping_from_grid(camera_grid(camera, INDOOR), camera.size, 'fitted', 0.5)
        place = world.motion.position[400]
        np.testing.assert_allclose(
            mapping.image_from_ground(place),
            camera.project(np.pad(place, ((0, 0), (0, 1)))),
            atol=0.5,
        )
        view = INDOOR.renderer(world, index).frame(400)[1]
        foot = view.box[:, :2] + view.box[:, 2:] * [0.5, 1]
        gap = np.linalg.norm(foot - mapping.image_from_ground(place[view.person]), axis=1)
        assert np.median(gap) < 20


def test_light_may_change_at_once():
    world = INDOOR.world(IndoorScenario(light_step=0.3, step_s=2.0))
    renderer = INDOOR.renderer(world, 0)
    before, after = renderer.frame(20)[0], renderer.frame(60)[0]
    assert after[200:, :300].mean() == pytest.approx(1.3 * before[200:, :300].mean(), rel=0.05)


def test_its_site_is_that_of_the_scene():
    site = load_site(config_file('indoor.yaml'))
    for camera in INDOOR.cameras(IndoorScenario()):
        mapping = site.cameras[camera.name].mapping()
        np.testing.assert_allclose(mapping.camera_position, camera.position, atol=0.02)


@pytest.mark.parametrize('wrong', [{'people': 7}, {'people': 0}, {'cameras': 9}])
def test_other_rooms_are_refused(wrong):
    with pytest.raises(ValueError, match='expected 1 to'):
        IndoorScenario(**wrong)
