"""What changes before a camera and is nobody; tracked by the real pipeline as live cameras do."""

import numpy as np
import pytest

from mctrack_experiments.scenarios.changing_views import SCENES, Renderer, score, tracked


@pytest.mark.parametrize(
    ('name', 'false_s', 'more_ids'),
    [
        ('bump', 2.0, 1),
        ('night', 2.0, 1),
        ('start', 5.0, 2),
        ('furniture', 9.0, 1),
        ('jitter', 2.0, 1),
        ('standing', 2.0, 1),
    ],
)
def test_no_real_person_is_lost_and_nobody_else_lasts(name, false_s, more_ids):
    scene = SCENES[name]()
    found = score(scene, tracked(scene))
    assert found['most_false'] <= 1
    assert found['false_s'] <= false_s
    assert found['longest_miss_s'] <= 1.0
    assert found['found'] == len(scene.people(10.0))
    assert found['ids'] <= found['found'] + more_ids


def test_who_walked_in_and_stands_keeps_the_id_beside_the_chair_that_goes():
    scene = SCENES['furniture']()
    last = None
    for index, tracks in enumerate(tracked(scene)):
        if index == 30 * 12:
            last = tracks
            break
    places = np.array(list(scene.people(30 * 12 / 12.5).values()))
    distance = np.linalg.norm(last.position[:, None, :2] - places[None], axis=2)
    assert distance.min(axis=1).max() < 1.0
    assert distance.min(axis=0).max() < 1.0


def test_a_turned_camera_shows_the_floor_elsewhere():
    scene = SCENES['bump']()
    before, after = (Renderer(scene, 'north', 0).image(at) for at in (0.0, 24.9))
    assert np.abs(before.astype(int) - after).mean() > 5
