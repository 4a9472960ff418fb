import numpy as np
import pytest

from mctrack_experiments.datasets.stored import StoredScene, stamp_of
from mctrack_experiments.papers.covering.scenes import CoveringScene, everywhere
from mctrack_ros.config import config_from
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import JointConfig
from mctrack_ros.interfaces import Detections

RATE, FRAMES = 10.0, 60


@pytest.fixture(scope='session')
def walkers():
    """Return a scene of three people who walk side by side, seen by two cameras."""
    rng = np.random.default_rng(1)
    frame, person = map(np.ravel, np.mgrid[:FRAMES, :3])
    place = np.column_stack([0.1 * frame, 4.0 * person])
    detections = {}
    for camera in ('one', 'two'):
        seen = place + rng.normal(0, 0.1, place.shape)
        detections[camera] = [
            Detections.build(
                stamp_of(index, RATE),
                position=np.pad(seen[frame == index], ((0, 0), (0, 1))),
                covariance=np.tile(0.01 * np.eye(2), (3, 1, 1)),
            )
            for index in range(FRAMES)
        ]
    truth = Trajectories(frame, person + 1, place)
    stored = StoredScene(np.arange(FRAMES), RATE, detections, truth)
    fusion = config_from(JointConfig, {'batching': {'period': 1 / RATE}})
    return CoveringScene(stored, fusion, 1.0, everywhere, np.arange(20, FRAMES), 2.0)
