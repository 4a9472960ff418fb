from dataclasses import replace

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections, published, tick
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.interfaces import TEMPLATE_SIZE, EventCode

CAMERAS = ('one', 'two')
RED, BLUE, GREEN = 3, 20, 30


def template(colour, seed):
    """Colours of one in a kit: most in one bin, the rest varying from image to image."""
    if colour is None:
        return np.zeros(TEMPLATE_SIZE)
    rng = np.random.default_rng([colour, seed])
    bins = np.abs(rng.normal(0, 0.003, TEMPLATE_SIZE))
    bins[colour] += 0.6
    bins[40] += 0.4
    return bins / bins.sum()


class Scene:
    """Feed ticks of people, each given as a place and a colour, to a pipeline."""

    def __init__(self):
        config = JointConfig()  # tracks are to be exchanged in spite of their colours
        config = replace(config, association=replace(config.association, appearance_weight=12.0))
        self.pipeline, self.index, self.events = JointTracker(config, CAMERAS), 0, []

    def show(self, *people):
        stamp_ns = self.index * PERIOD_NS + PERIOD_NS // 2
        rows = detections(
            stamp_ns,
            [place for place, _ in people],
            template=[template(colour, self.index) for _, colour in people],
            box=np.array([[100 * row, 0, 20, 50] for row in range(len(people))]).reshape(-1, 4),
        )
        output = self.pipeline.step(tick(self.index, {name: rows for name in CAMERAS}))
        self.index += 1
        events = output.events
        for code, old, new in zip(events.event, events.old_id, events.new_id):
            self.events.append((EventCode(code), int(old), int(new)))
        return published(output)

    def hold(self, ticks, *people):
        for _ in range(ticks):
            shown = self.show(*people)
        return shown

    def count(self, code):
        return sum(each[0] == code for each in self.events)


def id_at(shown, place):
    return min(shown, key=lambda one: np.linalg.norm(shown[one] - place))


@pytest.fixture
def scene():
    return Scene()


def exchange(scene, left, right):
    """Two meet and each goes back to where he came from, dressed as given from then on."""
    for gap in np.linspace(3, 0.4, 30):
        scene.show(([-gap, 0], RED), ([gap, 0], BLUE))
    for gap in np.linspace(0.4, 3, 30):
        scene.show(([-gap, 0], left), ([gap, 0], right))
    return scene.hold(25, ([-3, 0], left), ([3, 0], right))


def test_ids_that_were_exchanged_in_an_encounter_are_corrected(scene):
    before = scene.hold(75, ([-3, 0], RED), ([3, 0], BLUE))
    red, blue = id_at(before, [-3, 0]), id_at(before, [3, 0])
    after = exchange(scene, BLUE, RED)
    assert (id_at(after, [-3, 0]), id_at(after, [3, 0])) == (blue, red)
    told = [each[1:] for each in scene.events if each[0] == EventCode.CORRECTION]
    assert sorted(told) == sorted([(red, blue), (blue, red)])


def test_who_leaves_an_encounter_as_he_came_keeps_his_id(scene):
    before = scene.hold(75, ([-3, 0], RED), ([3, 0], BLUE))
    after = exchange(scene, RED, BLUE)
    assert id_at(after, [-3, 0]) == id_at(before, [-3, 0])
    assert scene.count(EventCode.CORRECTION) == 0


def test_who_never_met_another_is_himself_whatever_he_looks_like(scene):
    before = scene.hold(75, ([-3, 0], RED), ([3, 0], BLUE))
    after = scene.hold(75, ([-3, 0], BLUE), ([3, 0], RED))
    assert id_at(after, [-3, 0]) == id_at(before, [-3, 0])


def test_who_has_turned_out_to_be_himself_is_so_whatever_he_looks_like_later(scene):
    scene.hold(75, ([-3, 0], RED), ([3, 0], BLUE))
    before = exchange(scene, RED, BLUE)
    after = scene.hold(400, ([-3, 0], BLUE), ([3, 0], RED))
    assert id_at(after, [-3, 0]) == id_at(before, [-3, 0])
    assert scene.count(EventCode.CORRECTION) == 0


def test_who_looks_like_nobody_known_is_not_taken_for_one_whose_looks_are_not_known(scene):
    before = scene.hold(150, ([-0.5, 0], RED))
    together = scene.hold(25, ([-0.5, 0], RED), ([0.5, 0], None))
    for gap in np.linspace(0.5, 4, 40):
        scene.show(([-gap, 0], GREEN), ([0.5, 0], None))
    after = scene.hold(50, ([-4, 0], GREEN), ([0.5, 0], None))
    assert id_at(after, [-4, 0]) == id_at(before, [-0.5, 0])
    assert id_at(after, [0.5, 0]) == id_at(together, [0.5, 0])


@pytest.mark.parametrize('ticks', [100, 175, 250])
def test_a_swap_with_one_whose_looks_are_not_known_is_corrected(scene, ticks):
    before = scene.hold(ticks, ([-0.5, 0], RED))
    together = scene.hold(25, ([-0.5, 0], RED), ([0.5, 0], BLUE))
    for gap in np.linspace(0.5, 4, 40):
        scene.show(([-gap, 0], BLUE), ([0.5, 0], RED))
    after = scene.hold(250, ([-4, 0], BLUE), ([0.5, 0], RED))
    assert id_at(after, [0.5, 0]) == id_at(before, [-0.5, 0])
    assert id_at(after, [-4, 0]) == id_at(together, [0.5, 0])


def test_who_was_lost_is_found_again_by_his_colours(scene):
    before = scene.hold(75, ([0, 0], RED), ([9, 0], BLUE))
    scene.hold(50, ([9, 0], BLUE))
    after = scene.hold(25, ([1, 0], RED), ([9, 0], BLUE))
    assert id_at(after, [1, 0]) == id_at(before, [0, 0])
    assert scene.count(EventCode.NEW) == 2


def test_who_looks_like_nobody_lost_is_new(scene):
    before = scene.hold(75, ([0, 0], RED), ([9, 0], BLUE))
    scene.hold(50, ([9, 0], BLUE))
    after = scene.hold(50, ([1, 0], BLUE), ([9, 0], BLUE))
    assert id_at(after, [1, 0]) not in before


def test_who_turns_up_farther_away_than_one_can_go_is_new(scene):
    before = scene.hold(75, ([0, 0], RED), ([9, 0], BLUE))
    scene.hold(50, ([9, 0], BLUE))
    after = scene.hold(50, ([0, 40], RED), ([9, 0], BLUE))
    assert id_at(after, [0, 40]) not in before


def test_who_was_lost_long_ago_is_forgotten(scene):
    before = scene.hold(75, ([0, 0], RED), ([9, 0], BLUE))
    scene.hold(550, ([9, 0], BLUE))
    after = scene.hold(25, ([1, 0], RED), ([9, 0], BLUE))
    assert id_at(after, [1, 0]) not in before


def test_without_colours_nothing_is_corrected():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    for index in range(200):
        gap = abs(100 - index) * 0.03
        places = [[-gap, 0], [gap, 0]]
        output = pipeline.step(tick(index, {name: places for name in CAMERAS}))
        assert not (output.events.event == EventCode.CORRECTION).any()


def test_two_who_look_different_are_not_taken_for_one_when_one_hides_the_other(scene):
    before = scene.hold(150, ([-3, 0], RED), ([3, 0], BLUE))
    for gap in np.linspace(3, 0.3, 30):
        scene.show(([-gap, 0], RED), ([gap, 0], BLUE))
    scene.hold(25, ([-0.3, 0], RED), ([0.3, 0], BLUE))
    scene.hold(50, ([-0.3, 0], RED))
    after = scene.hold(50, ([-0.3, 0], RED), ([3, 0], BLUE))
    assert after.keys() == before.keys()
    assert id_at(after, [3, 0]) == id_at(before, [3, 0])
