"""People walk behind a wall that reaches from their feet upwards."""

import numpy as np
import pytest

RED = (30, 30, 200)
BEHIND_M = 0.4
WALL = (90, 90, 90)


@pytest.fixture
def new_walled(new_stage):
    """Return a maker of stages with a wall so high along y = 0, from x = 0 on."""

    def make(wall_m, **config):
        stage = new_stage(**config)
        stage.pipeline = type(stage.pipeline)(stage.config, stage.mapping)
        corner = np.zeros((1, 2))
        left, bottom = np.rint(stage.mapping.image_from_ground(corner)[0]).astype(int)
        top = bottom - round(stage.mapping.height_px(corner, wall_m)[0])
        stage.bare = stage.image

        def image(people):
            shown = stage.bare(people)
            noise = stage.rng.normal(0, 2, shown[top:bottom, left:].shape)
            shown[top:bottom, left:] = np.clip(WALL + noise, 0, 255)
            return shown

        stage.image = image
        stage.empty()
        return stage

    return make


def passed(stage):
    """Let somebody walk past behind the wall, then nobody; return how far off he is told, m."""
    errors = []
    for x in np.linspace(-3.5, 3.0, 150):
        reported = stage.show([((x, BEHIND_M), RED)]).detections
        if x > 1.0:
            assert len(reported) == 1
            errors.append(np.linalg.norm(reported.position[0, :2] - [x, BEHIND_M]))
    stage.empty()
    return np.median(errors)


def sat_down(stage, seat):
    """Let somebody come, sit down, rise and go; return how far off he is told sitting, m."""
    bare, place = stage.image, np.array([seat])
    foot = stage.mapping.image_from_ground(place)[0]
    head = round(foot[1] - stage.mapping.height_px(place, 1.3)[0])

    def sitting(people):
        image = bare(people)
        image[:head] = bare([])[:head]
        return image

    off = []
    for x in np.linspace(-3.0, 0.0, 60):
        stage.show([((seat[0] + x, seat[1]), RED)])
    stage.image = sitting
    for _ in range(60):
        reported = stage.show([(seat, RED)]).detections
        off += np.linalg.norm(reported.position[:, :2] - seat, axis=1).tolist()
    stage.image = bare
    for x in np.linspace(0.0, 3.0, 60):
        stage.show([((seat[0] + x, seat[1]), RED)])
    stage.empty()
    return max(off)


@pytest.mark.parametrize(('wall_m', 'before_m'), [(0.6, 0.8), (0.8, 1.2)])
def test_where_people_lack_their_feet_these_are_found_below_the_head(new_walled, wall_m, before_m):
    stage = new_walled(wall_m)
    errors = [passed(stage) for _ in range(4)]
    assert min(errors[:2]) > before_m
    assert max(errors[2:]) < 0.25


def test_unless_heights_are_remembered_feet_are_where_silhouettes_end(new_walled):
    stage = new_walled(0.8, filter={'height_time_s': 0.0})
    assert min(passed(stage) for _ in range(4)) > 1.2


def test_who_comes_out_of_a_door_behind_the_wall_is_as_tall_as_usual(new_walled):
    stage = new_walled(0.6)
    for _ in range(3):
        passed(stage)
    reported = [
        stage.show([((x, BEHIND_M), RED)]).detections.position for x in np.linspace(1.0, 2.5, 40)
    ]
    last = np.array([place[0, :2] for place in reported[10:]])
    off = last - np.column_stack([np.linspace(1.0, 2.5, 40)[10:], np.full(30, BEHIND_M)])
    assert np.median(np.linalg.norm(off, axis=1)) < 0.35


def test_a_wall_that_is_taken_away_is_forgotten(new_walled):
    stage = new_walled(0.6)
    for _ in range(4):
        passed(stage)
    stage.image = stage.bare
    for _ in range(7):
        passed(stage)
    assert sat_down(stage, (1.5, BEHIND_M)) < 0.5


def test_people_who_are_seen_whole_teach_nothing(new_stage):
    path = [(x, 1.0) for x in [*np.linspace(-2.5, 2.5, 120), *np.linspace(2.5, -2.5, 120)]]
    reported = []
    for settings in ({}, {'filter': {'height_time_s': 0.0}}):
        stage = new_stage(**settings)
        reported.append([stage.show([(place, RED)]).detections.position for place in path * 2])
    np.testing.assert_array_equal(*reported)


def test_where_people_sit_down_they_stay_where_they_sat(new_stage):
    stage = new_stage()
    assert max(sat_down(stage, (0.0, 0.0)) for _ in range(4)) < 0.5
