"""The hall: people close by, groups through one door, shadows towards a camera."""

from dataclasses import replace

import numpy as np
import pytest

from mctrack_ros.resources import config_file
from mctrack_ros.simulation import HALL, HallScenario, true_detections
from mctrack_ros.simulation.calibration import write_calibration
from mctrack_ros.simulation.indoor import hall
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site


@pytest.fixture(scope='module', params=[1, 2, 3])
def world(request):
    return HALL.world(HallScenario(seed=request.param))


def entries(world):
    """Return steps and people, at which somebody comes in."""
    return np.nonzero(np.diff(world.active.astype(int), axis=0) > 0)


def test_everybody_comes_and_goes_through_the_door(world):
    assert world.active.any(axis=0).all()
    assert not world.active[0].any()
    for sign in (1, -1):
        step, person = np.nonzero(np.diff(world.active.astype(int), axis=0) == sign)
        for side in (step, step + 1):
            place = world.motion.position[side, person]
            assert np.abs(place - (hall.DOOR_X, hall.DOOR_Y)).max() < hall.DOOR_M / 2


def test_groups_come_in_together(world):
    group = hall.group_of(world.scenario)
    step, person = entries(world)
    first = np.full(len(group), -1)
    first[person] = step
    assert sorted(np.bincount(group)) == sorted(hall.GROUPS)
    for each in range(len(hall.GROUPS)):
        assert np.ptp(first[group == each]) * world.scenario.period_s < 2.5


def test_people_are_close_to_cameras_and_to_one_another(world):
    place = np.array([camera.position[:2] for camera in world.cameras])
    away = np.linalg.norm(world.motion.position[:, None] - place[:, None], axis=3)
    seen = away[world.feet_in_view]
    assert 1.3 < seen.min() < 2.5
    assert np.percentile(seen, 99) < 10
    assert world.feet_in_view.any(axis=1)[world.active].all()
    figures = HALL.meter(world).result().figures()
    assert figures['close_share'] > 0.5
    assert figures['least_distance_m'] > 0.35


def test_a_silhouette_lies_where_the_truth_box_is(world):
    step, lit = 300, replace(world, scenario=replace(world.scenario, shadows=False))
    for index, camera in enumerate(world.cameras):
        renderer = HALL.renderer(lit, index)
        image, view = renderer.frame(step)
        rows = true_detections(world, step, view)
        assert len(rows) >= 2
        assert set(rows.track_id - 1) <= set(np.flatnonzero(world.active[step]))
        for box, track_id, truncated in zip(rows.box, rows.track_id, rows.truncated):
            ground = np.append(world.motion.position[step, track_id - 1], 0.0)
            top = ground + np.array([0, 0, world.appearance.height[track_id - 1]])
            if not truncated:
                foot, head = camera.project([ground, top])
                assert box[1] == pytest.approx(head[1], abs=0.12 * box[3])
                assert box[1] + box[3] == pytest.approx(foot[1], abs=0.12 * box[3])
        inside = np.zeros(image.shape[:2], np.bool_)
        for left, upper, width, height in view.box.astype(int):
            inside[upper : upper + height, left : left + width] = True
        changed = np.abs(image.astype(int) - renderer.frame(0)[0]).max(axis=2) > 40
        assert changed[inside].mean() > 0.3
        assert changed[~inside].mean() < 1e-3


def test_who_is_outside_is_seen_through_the_door_alone(world):
    step, person = entries(world)
    shown = HALL.renderer(world, 0).frame(step[0])[1]
    assert person[0] in shown.person
    box = shown.box[list(shown.person).index(person[0])]
    door = world.cameras[0].project(
        [(hall.DOOR_X, hall.DOOR_Y + side, up) for side, up in ((0.6, 2.1), (-0.6, 0.0))]
    )
    assert (box[:2] >= door[0] - 2).all()
    assert (box[:2] + box[2:] <= door[1] + 2).all()
    assert not len(HALL.renderer(world, 0).frame(0)[1].person)


def test_shadows_fall_towards_the_first_camera_and_can_be_left_out(world):
    step, camera = 200, world.cameras[0]
    without = replace(world, scenario=replace(world.scenario, shadows=False))
    lit, (shaded, view) = (HALL.renderer(each, 0).frame(step)[:2] for each in (without, world))
    darker = np.argwhere((lit[0].astype(int) - shaded).min(axis=2) > 20)[:, ::-1] + 0.5
    assert len(darker) > 500
    place = camera.ground(darker)
    feet = world.motion.position[step, view.person[world.active[step, view.person]]]
    before = feet[None, :, 0] - place[:, None, 0]
    beside = np.abs(feet[None, :, 1] - place[:, None, 1])
    near = (beside < 0.6) & (before > -0.6) & (before < 2.6)
    assert near.any(axis=1).mean() > 0.98
    assert before.max() > 1.5


def test_a_seed_gives_the_same_images_and_another_does_not():
    first, same, other = (
        HALL.renderer(HALL.world(HallScenario(seed=seed)), 2).frame(300)[0] for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, same)
    assert (first != other).mean() > 0.5


def test_shipped_files_are_what_the_code_gives(tmp_path):
    write_calibration(HallScenario(), tmp_path)
    shipped = config_file('hall.yaml').parent / 'hall'
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == ['cam1.xml', 'cam2.xml', 'cam3.xml', 'cam4.xml', 'scene.xml']
    for name in names:
        assert (shipped / name).read_text() == (tmp_path / name).read_text(), name


def test_its_site_gets_occupancy():
    site, why = with_tracker(load_site(config_file('hall.yaml')))
    assert site.fusion.tracker == 'occupancy'
    assert 'occupancy' in why


def test_another_number_of_cameras_is_refused():
    with pytest.raises(ValueError, match='expected 1 to 4'):
        HallScenario(cameras=5)
