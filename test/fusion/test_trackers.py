"""What a camera tells on several topics is joined by image."""

import pytest

from mctrack_ros.fusion import Joining, fusion_method, joined
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.occupancy.config import OccupancyConfig
from mctrack_ros.interfaces import Detections, Foreground
from mctrack_ros.interfaces.rows import MOST_WAITING


@pytest.fixture
def joining():
    return Joining(OccupancyConfig())


def test_a_message_is_complete_by_itself_where_there_is_one_topic():
    alone = Detections.build(3)
    parts = Joining(JointConfig()).add('north', alone)
    assert parts == {'detections': alone}
    assert joined(fusion_method(JointConfig()), parts) is alone


@pytest.mark.parametrize('first', [0, 1])
def test_an_image_is_complete_with_its_last_message_in_any_order(joining, first):
    told = [Detections.build(3, position=[[1, 2, 0]]), Foreground.build(3)]
    assert joining.add('north', told[first]) is None
    parts = joining.add('north', told[1 - first])
    whole = joined(fusion_method(OccupancyConfig()), parts)
    assert (whole.detections, whole.foreground) == tuple(told)
    assert (whole.stamp_ns, len(whole)) == (3, 1)
    assert whole.at(9).foreground.stamp_ns == whole.at(9).stamp_ns == 9


def test_cameras_and_images_are_kept_apart(joining):
    assert joining.add('north', Detections.build(3)) is None
    assert joining.add('south', Foreground.build(3)) is None
    assert joining.add('north', Foreground.build(4)) is None
    assert joining.add('north', Foreground.build(3)) is not None
    assert joining.add('north', Detections.build(4)) is not None


def test_an_image_that_stays_incomplete_holds_up_none(joining):
    joining.add('north', Detections.build(1))
    for stamp_ns in range(2, 30):
        assert joining.add('north', Foreground.build(stamp_ns)) is None
        assert joining.add('north', Detections.build(stamp_ns)) is not None


def test_of_incomplete_images_only_the_last_are_kept(joining):
    for stamp_ns in range(20):
        joining.add('north', Detections.build(stamp_ns))
    kept = range(20 - MOST_WAITING, 20)
    assert all(joining.add('north', Foreground.build(stamp_ns)) for stamp_ns in kept)
    assert joining.add('north', Foreground.build(19 - MOST_WAITING)) is None


def test_a_message_that_comes_twice_completes_nothing(joining):
    assert joining.add('north', Detections.build(3)) is None
    assert joining.add('north', Detections.build(3)) is None
    assert joining.add('north', Foreground.build(3)) is not None
