import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_experiments.bench.fusion.hostile_input import SPOILERS
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.fusion import JointConfig, open_batcher
from mctrack_ros.interfaces import CameraDetections, Candidates, Decisions
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.replay.drive import drive

CONFIG = JointConfig()
CAMERAS = ('one', 'two')


def crowd(index):
    """Return people who stand so close that their detections are taken for one another's."""
    rng = np.random.default_rng(index)
    places = np.array([[0, 0], [0.5, 0], [1.0, 0.2]])
    return {name: places + rng.normal(0, 0.2, (3, 2)) for name in CAMERAS}


def spoiled_ticks(name):
    rng, batcher = np.random.default_rng(1), open_batcher(CONFIG, CAMERAS)
    for index in range(30):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        messages = [
            CameraDetections(camera, detections(stamp_ns, rows))
            for camera, rows in crowd(index).items()
        ]
        if index >= 10:
            messages = SPOILERS[name](messages, index - 10, rng)
        for each in messages:
            yield from batcher.add(each.camera, each.rows, stamp_ns)
        yield from batcher.flush()


@pytest.mark.parametrize('name', ['bad_covariances', 'infinite_positions', 'twice', 'wild_ids'])
def test_whatever_comes_can_be_explained_and_travels(name):
    for ticked in drive(CONFIG, CAMERAS, spoiled_ticks(name), lambda tick: True):
        why = ticked.explanation
        for rows, kind in ((why.candidates, Candidates), (why.decisions, Decisions)):
            cloud = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
            assert len(rows_from_cloud(cloud, kind)) == len(rows)
