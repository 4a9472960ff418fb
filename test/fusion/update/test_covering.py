from dataclasses import replace

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections, published, tick
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.association.config import ASSOCIATION
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.information import updated
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.covering import CoveringAssociation
from mctrack_ros.tracking.kalman import position_matrix, update

CAMERAS = ('one', 'two')


def config_of(method):
    default = JointConfig()
    return replace(default, association=ASSOCIATION.made(method))


@pytest.fixture
def config():
    return config_of('covering_graph')


def run(config, frames_of, ticks, pipeline=None, start=0):
    pipeline = pipeline or JointTracker(config, CAMERAS)
    return [pipeline.step(tick(index, frames_of(index))) for index in range(start, start + ticks)]


def associated(table, images, config):
    rows = [detections(PERIOD_NS, each, sigma=0.2) for each in images]
    cameras = list(range(len(images)))
    batch = Batch(rows, cameras, PERIOD_NS, config)
    return CoveringAssociation(table, batch, config.association), batch


def tracks(positions):
    table = TrackTable.blank(len(positions), len(CAMERAS))
    table.mean[:, :2] = positions
    table.covariance[:] = np.diag([0.09, 0.09, 1.0, 1.0])
    return table


def test_a_track_is_updated_by_its_primary_sensor_alone(config):
    table = tracks([[0.0, 0.0]])
    association, batch = associated(table, [[[0.2, 0.0]], [[-0.3, 0.1]]], config)
    mean, covariance = updated(table.mean, table.covariance, association.solve())
    expected = update(
        table.mean, table.covariance, np.array([[0.2, 0.0]]), batch.noise[:1], position_matrix()
    )
    np.testing.assert_allclose(mean, expected[0], atol=1e-6)
    np.testing.assert_allclose(covariance, expected[1], atol=1e-6)
    seen_by, seen = association.pairs()
    assert seen_by.tolist() == [0, 0]
    assert seen.tolist() == [0, 1]


def test_a_sensor_without_a_valid_detection_does_not_block_the_others(config):
    table = tracks([[0.0, 0.0]])
    association, _ = associated(table, [[[9.0, 9.0]], [[0.2, 0.0]]], config)
    assert updated(table.mean, table.covariance, association.solve())[0][0, 0] > 0.05
    assert association.pairs()[1].tolist() == [1]


def test_what_is_near_a_track_of_another_sensor_is_consumed(config):
    images = [[[0.0, 0.0]], [[0.1, 0.0], [0.5, 0.0], [9.0, 9.0]]]
    association, _ = associated(tracks([[0.0, 0.0]]), images, config)
    assert association.consumed.tolist() == [1, 2]


def test_who_is_covered_by_another_sensor_takes_what_is_left_there(config):
    """In the second image the other one's detection is nearer to him."""
    images = [[[-0.5, 0.0]], [[1.0, 0.0], [-1.1, 0.0]]]
    association, _ = associated(tracks([[0.0, 0.0], [2.0, 0.0]]), images, config)
    track, row = association.pairs()
    assert list(zip(track.tolist(), row.tolist())) == [(0, 0), (0, 2), (1, 1)]


def test_consumed_detections_start_no_track(config):
    def frames(index):
        return {'one': [[0.06 * index, 0]], 'two': [[0.06 * index, 0.3], [0.06 * index, -0.5]]}

    pipeline = JointTracker(config, CAMERAS)
    run(config, lambda index: {name: [[0.06 * index, 0]] for name in CAMERAS}, 25, pipeline)
    outputs = run(config, frames, 50, pipeline, 25)
    assert max(len(output.tracks) for output in outputs) == 1
    shared = run(config_of('gnn'), frames, 50)
    assert max(len(output.tracks) for output in shared) > 1


def test_walkers_keep_their_ids_from_one_sensor_to_the_next(config):
    def frames(index):
        place = [[0.06 * index, 0.0], [0.06 * index, 4.0]]
        return {'one': place if index < 90 else [], 'two': place if index > 70 else []}

    outputs = run(config, frames, 130)
    assert len(published(outputs[60])) == 2
    assert published(outputs[60]).keys() == published(outputs[-1]).keys()
