import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode, EventCode
from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.tracker import SilhouetteTracker, SilhouetteTrackerConfig

SIZE = (480, 640)
PERIOD_NS = 250_000_000
PERSON, CAR = (20, 56), (120, 60)


class Film:
    """Shows a tracker blocks of foreground, each (left, bottom, (width, height), grey)."""

    def __init__(self, mapping):
        self.tracker = SilhouetteTracker(SilhouetteTrackerConfig(), SizeTable(mapping))
        self.background = Background(BackgroundConfig())
        self.background.begin(np.full((*SIZE, 3), 100, np.uint8))
        self.index, self.events = 0, []

    def show(self, *blocks):
        grey, mask = np.full(SIZE, 100, np.uint8), np.zeros(SIZE, np.uint8)
        for left, bottom, (width, height), value in blocks:
            window = np.s_[bottom - height : bottom, max(left, 0) : max(left + width, 0)]
            grey[window], mask[window] = value, 255
        self.index += 1
        log = EventLog(self.index * PERIOD_NS)
        found = find_silhouettes(mask, grey, ComponentConfig(1, 1))
        self.tracker.step(found, self.background, self.index * PERIOD_NS, log)
        self.events += [EventCode(code) for code in log.rows().event]
        objects = self.tracker.objects
        large = objects.box[:, 2] > 60
        seen = objects.matched
        objects.class_id[seen] = np.where(large, ClassCode.VEHICLE, ClassCode.PERSON)[seen]
        return objects

    def ids(self):
        objects = self.tracker.objects
        return objects.local_id[objects.established & objects.matched].tolist()


@pytest.fixture
def film(mapping):
    return Film(mapping)


def walker(step, start=100, pace=8):
    return (start + pace * step, 380, PERSON, 60)


def test_somebody_who_walks_is_one_object(film):
    for step in range(24):
        film.show(walker(step))
    assert film.ids() == [1]


def test_two_who_pass_keep_their_ids(film):
    for step in range(40):
        film.show(walker(step), (420 - 8 * step, 380, PERSON, 140))
        if step == 10:
            left = film.tracker.objects.box[0, 0]
    assert left < 300
    assert sorted(film.ids()) == [1, 2]
    assert film.tracker.objects.box[0, 0] > film.tracker.objects.box[1, 0]


def test_a_pedestrian_before_a_vehicle_is_found_again_behind_it(film):
    for step in range(40):
        film.show(walker(step), (600 - 24 * step, 390, CAR, 140))
    assert film.ids() == [1]
    assert film.tracker.objects.class_id.tolist() == [ClassCode.PERSON]


def test_a_crumb_does_not_take_the_place_of_whoever_leaves_it_behind(film):
    for step in range(16):
        film.show(walker(step))
    for _ in range(16, 22):
        film.show((226, 380, (4, 4), 60))
    for step in range(22, 26):
        film.show(walker(step), (226, 380, (4, 4), 60))
    assert film.ids() == [1]


def test_whoever_comes_where_a_vehicle_has_left_does_not_become_it(film):
    for step in range(26):
        film.show((480 - 24 * step, 390, CAR, 140))
    for step in range(16):
        film.show((8 * step - 10, 380, PERSON, 60))
    assert film.tracker.objects.class_id.tolist() == [ClassCode.PERSON]
    assert film.ids() != [1]


def test_a_stripe_beside_a_pedestrian_is_not_taken_for_him(film):
    for step in range(16):
        film.show(walker(step))
    film.show((216, 350, (60, 6), 60))
    assert not film.tracker.objects.matched[0]


def test_an_exit_is_noted_where_an_object_leaves(film):
    for step in range(34):
        film.show(walker(step, start=200, pace=-8))
        film.tracker.objects.announced[:] = film.tracker.objects.established
    assert film.events == [EventCode.EXIT]
