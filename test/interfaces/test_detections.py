import numpy as np

from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import ROSBAGS_CLASSES


def test_only_a_lone_row_that_says_nothing_is_blind():
    assert Detections.blind(1).is_blind
    assert not Detections.build(1).is_blind
    assert not Detections.blind(1).replace(track_id=[7]).is_blind
    assert not Detections.build(1, position=[[0.0, 0.0, 0.0]], score=[0.0]).is_blind
    assert not Detections.build(1, position=[[np.nan] * 3]).is_blind
    assert not Detections.joined(1, [Detections.blind(1), Detections.blind(1)]).is_blind


def test_a_blind_message_stays_so_on_its_way():
    cloud = cloud_from_rows(Detections.blind(1), ROSBAGS_CLASSES, 'map')
    assert rows_from_cloud(cloud, Detections).is_blind
