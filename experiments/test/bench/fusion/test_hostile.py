import numpy as np
import pytest

from mctrack_experiments.bench.fusion.hostile import endured
from mctrack_experiments.bench.fusion.hostile_input import FLOOD, SPOILERS
from mctrack_ros.fusion.measurements.admission import usable_rows
from mctrack_ros.interfaces import CameraDetections, Detections


def messages():
    place = np.column_stack([np.arange(4.0), np.arange(4.0), np.zeros(4)])
    rows = Detections.build(5, position=place, covariance=np.tile(np.eye(2), (4, 1, 1)))
    return [CameraDetections(f'cam{index}', rows) for index in range(5)]


def spoiled(name, step=0):
    return SPOILERS[name](messages(), step, np.random.default_rng(1))


@pytest.mark.parametrize('name', ['bad_covariances', 'infinite_positions'])
def test_every_second_detection_becomes_unusable(name):
    for message in spoiled(name):
        assert usable_rows(message.rows).tolist() == [False, True, False, True]


@pytest.mark.parametrize('name', ['flood', 'spot_flood', 'lasting_flood'])
def test_a_flood_is_ten_thousand_detections_in_a_tick(name):
    assert sum(len(each.rows) for each in spoiled(name)) == FLOOD + 20


@pytest.mark.parametrize(('name', 'count'), [('flood', 20), ('lasting_flood', FLOOD + 20)])
def test_only_a_lasting_flood_comes_again(name, count):
    assert sum(len(each.rows) for each in spoiled(name, 1)) == count


@pytest.mark.parametrize(('name', 'count'), [('silent', 0), ('empty', 5), ('twice', 15)])
def test_messages_are_left_out_emptied_or_repeated(name, count):
    assert len(spoiled(name)) == count


def test_unusable_detections_are_counted_and_tracking_goes_on(toolkit):
    outcome = endured(toolkit, 'bad_covariances')
    assert outcome.refused > 500
    assert outcome.mota_after > 0.9
    assert outcome.worst_ms > 0
