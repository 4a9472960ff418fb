import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_experiments.bench.fusion.hostile_input import SPOILERS
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.fusion import DecisionRecorder, FusionPipeline, JointConfig, open_batcher
from mctrack_ros.interfaces import CameraDetections, Candidates, Decisions
from mctrack_ros.recording import ROSBAGS_CLASSES

CONFIG = JointConfig()
CAMERAS = ('one', 'two')


def crowd(index):
    """Return people who stand so close that their detections are taken for one another's."""
    rng = np.random.default_rng(index)
    places = np.array([[0, 0], [0.5, 0], [1.0, 0.2]])
    return {name: places + rng.normal(0, 0.2, (3, 2)) for name in CAMERAS}


@pytest.mark.parametrize('name', ['bad_covariances', 'infinite_positions', 'twice', 'wild_ids'])
def test_whatever_comes_can_be_explained_and_travels(name):
    rng = np.random.default_rng(1)
    batcher, pipeline = open_batcher(CONFIG, CAMERAS), FusionPipeline(CONFIG, CAMERAS)
    for index in range(30):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        messages = [
            CameraDetections(camera, detections(stamp_ns, rows))
            for camera, rows in crowd(index).items()
        ]
        if index >= 10:
            messages = SPOILERS[name](messages, index - 10, rng)
        ticks = []
        for each in messages:
            ticks += batcher.add(each.camera, each.rows, stamp_ns)
        for each in [*ticks, *batcher.flush()]:
            recorder = DecisionRecorder()
            pipeline.step(each, recorder)
            why = recorder.explanation
            for rows, kind in ((why.candidates, Candidates), (why.decisions, Decisions)):
                cloud = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
                assert len(rows_from_cloud(cloud, kind)) == len(rows)
