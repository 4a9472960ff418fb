import numpy as np
import pytest

from mctrack_ros.simulation import Scenario, Sight, World


def behind(world, camera_index, place, distance):
    """Return the place at some distance behind another, seen from a camera, m."""
    away = np.asarray(place) - world.cameras[camera_index].position[:2]
    return np.asarray(place) + distance * away / np.linalg.norm(away)


def test_somebody_alone_is_wholly_visible(staged):
    view = Sight(staged({3: (20, 30)}), 0).view(0)
    assert view.person.tolist() == [3]
    assert view.visible.tolist() == [1.0]
    assert not view.truncated[0]
    assert len(view.touching) == 0


def test_the_nearer_one_hides_the_farther(staged):
    far = behind(staged({}), 0, (20, 30), 1.0)
    view = Sight(staged({3: (20, 30), 4: far}), 0).view(0)
    assert view.person.tolist() == [4, 3]
    assert view.visible[0] < 0.7
    assert view.visible[1] == 1
    assert view.touching.tolist() == [[0, 1]]


def test_box_and_pixels_do_not_depend_on_who_is_in_front(staged):
    far = behind(staged({}), 0, (20, 30), 1.0)
    alone, hidden = (Sight(staged(p), 0).view(0) for p in ({4: far}, {4: far, 3: (20, 30)}))
    np.testing.assert_array_equal(alone.box[0], hidden.box[0])
    assert alone.pixels[0] == hidden.pixels[0]


def test_people_side_by_side_neither_hide_nor_touch(staged):
    view = Sight(staged({3: (20, 30), 4: (23, 28)}), 0).view(0)
    assert view.visible.tolist() == [1.0, 1.0]
    assert len(view.touching) == 0


def test_the_image_edge_truncates_but_does_not_hide(staged):
    world = staged({})
    camera = world.cameras[0]
    place = camera.ground([2.0, 300.0])
    view = Sight(staged({3: place}), 0).view(0)
    assert view.truncated[0]
    assert view.box[0, 0] == 0
    assert view.visible[0] == 1


@pytest.mark.parametrize('speeds', [(0, 0.5), (0.5, 3), (3, 8)])
def test_bottom_centre_of_the_box_is_the_foot_point(speeds):
    world = World.simulated(Scenario(seed=2, duration_s=12))
    errors = []
    for index, camera in enumerate(world.cameras):
        sight = Sight(world, index)
        for step in range(0, world.scenario.steps, 30):
            view = sight.view(step)
            speed = np.linalg.norm(world.motion.velocity[step, view.person], axis=1)
            kept = ~view.truncated & (speed >= speeds[0]) & (speed < speeds[1])
            box = view.box[kept]
            foot = np.column_stack([box[:, 0] + box[:, 2] / 2, box[:, 1] + box[:, 3]])
            errors.append(camera.ground(foot) - world.motion.position[step, view.person[kept]])
    errors = np.concatenate(errors)
    assert len(errors) > 50
    assert np.abs(errors.mean(axis=0)).max() < 0.06
    assert np.median(np.linalg.norm(errors, axis=1)) < 0.25
