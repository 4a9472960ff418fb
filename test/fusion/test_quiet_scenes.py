"""Few detections, or none, decoded from messages as the live node gets them."""

from itertools import product

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.fusion import DecisionRecorder, JointConfig, JointTracker, open_batcher
from mctrack_ros.fusion.association.config import ASSOCIATION
from mctrack_ros.interfaces import Detections, Feedback
from mctrack_ros.perception import FeedbackBuffer
from mctrack_ros.recording import ROSBAGS_CLASSES

CAMERAS = ('cam1', 'cam2', 'cam3')
COUNTS = (0, 1, 2, 7)


def received(rows):
    """Return rows as they come out of a message."""
    return rows_from_cloud(cloud_from_rows(rows, ROSBAGS_CLASSES, 'map'), type(rows))


def people(stamp_ns, count, rng):
    places = 3.0 * np.arange(count)
    position = np.column_stack([places, 0.5 * places, np.zeros(count)])
    position[:, :2] += rng.normal(0.0, 0.05, (count, 2))
    return Detections.build(
        stamp_ns,
        position=position,
        covariance=np.tile(0.01 * np.eye(2), (count, 1, 1)),
        box=np.column_stack([20 * places, places, np.full(count, 20), np.full(count, 50)]),
        template=rng.dirichlet(np.ones(48), count),
        score=np.full(count, 0.9),
        local_id=np.arange(1, count + 1),
    )


@pytest.mark.parametrize('method', ['weighed_gnn', 'jpda', 'covering_graph'])
def test_any_number_of_detections_of_any_camera_gives_the_tracks_of_arrays_built_here(method):
    config = JointConfig(association=ASSOCIATION.made(method))
    live, direct = (JointTracker(config, CAMERAS) for _ in range(2))
    batchers = open_batcher(config, CAMERAS), open_batcher(config, CAMERAS)
    rng, buffer = np.random.default_rng(1), FeedbackBuffer(PERIOD_NS, 2 * PERIOD_NS)
    for index, counts in enumerate(product(COUNTS, repeat=len(CAMERAS)), 100):
        stamp_ns = index * PERIOD_NS
        for camera, count in zip(CAMERAS, counts):
            rows = people(stamp_ns, count, rng)
            ticks = batchers[0].add(camera, received(rows), stamp_ns)
            others = batchers[1].add(camera, rows, stamp_ns)
        for tick, other in zip(ticks, others, strict=True):
            recorder = DecisionRecorder() if index % 2 else None
            tracks, expected = live.step(tick, recorder).tracks, direct.step(other).tracks
            for name in tracks.COLUMNS:
                one, two = getattr(tracks, name), getattr(expected, name)
                assert one.tobytes() == two.tobytes(), (counts, name)
            buffer.push(received(live.feedback()))
    assert len(tracks) >= 7


@pytest.mark.parametrize('kind', [Detections, Feedback])
@pytest.mark.parametrize('counts', list(product((0, 1, 2), repeat=3)))
def test_received_rows_join_row_after_row(kind, counts):
    parts = [received(kind.build(0, position=np.zeros((count, 3)))) for count in counts]
    joined = kind.joined(0, parts)
    for name in kind.COLUMNS:
        assert getattr(joined, name).flags.c_contiguous, name
