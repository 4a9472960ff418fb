import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.objects import ObjectConfig, ObjectList
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Stationarity
from mctrack_ros.perception.silhouettes.reference_update.stationary_false_foreground import (
    FalseForegroundConfig,
    without_false_foreground,
)

SIZE = (480, 640)
BOX = np.s_[300:340, 300:312]


@pytest.fixture(scope='module')
def sizes(mapping):
    return SizeTable(mapping)


@pytest.fixture
def objects():
    return ObjectList(ObjectConfig())


def kept(sizes, objects, seconds, still_s=1.0):
    """Show a box for some time; return how many silhouettes are left, and the background."""
    config = FalseForegroundConfig(still_s=still_s)
    background = Background(BackgroundConfig())
    background.begin(np.full((*SIZE, 3), 100, np.uint8))
    grey = np.full(SIZE, 100, np.uint8)
    grey[BOX] = 60
    mask, still = np.where(grey == 60, np.uint8(255), np.uint8(0)), Stationarity(0.2)
    image = np.repeat(grey[..., None], 3, axis=2)
    for index in range(round(seconds * 4) + 2):
        still.watch(image, mask, index * 250_000_000, 7.0)
    found = find_silhouettes(mask, grey, ComponentConfig(1, 1))
    left = without_false_foreground(found, still, objects, sizes, image, background, config)
    return len(left.shapes), background


def somebody(objects, speed_px=0.0, kind=ClassCode.PERSON):
    grey = np.full(SIZE, 60, np.uint8)
    mask = np.zeros(SIZE, np.uint8)
    mask[BOX] = 255
    objects.start(find_silhouettes(mask, grey, ComponentConfig(1, 1)).shapes, 0)
    objects.velocity[:, 0], objects.class_id[:] = speed_px, kind
    return objects


def test_what_stands_still_where_nobody_came_is_background(sizes, objects):
    count, background = kept(sizes, objects, 1.5)

    assert count == 0
    assert (background.model[BOX] == 60).all()


def test_what_has_just_come_is_not(sizes, objects):
    assert kept(sizes, objects, 0.5)[0] == 1


def test_as_printed_nothing_is_left_out(sizes, objects):
    assert kept(sizes, objects, 3.0, still_s=0.0)[0] == 1


def test_whoever_stopped_there_is_seen_on(sizes, objects):
    assert kept(sizes, somebody(objects), 3.0)[0] == 1


def test_whoever_walks_past_did_not_stop_there(sizes, objects):
    assert kept(sizes, somebody(objects, speed_px=40.0), 3.0)[0] == 0


def test_a_vehicle_is_seen_on_while_it_creeps(sizes, objects):
    assert kept(sizes, somebody(objects, 40.0, ClassCode.VEHICLE), 3.0)[0] == 1
