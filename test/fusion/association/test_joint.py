import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.association.joint import JointAssociation
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.information import updated
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import position_matrix, update

CONFIG = JointConfig()
SURE = JointAssociationConfig(false_density=1e-9)


def tracks(positions, sigma=0.3):
    table = TrackTable.blank(len(positions), 4)
    table.track_id[:] = np.arange(1, len(positions) + 1)
    table.mean[:, :2] = positions
    table.covariance[:] = np.diag([sigma**2, sigma**2, 1.0, 1.0])
    table.confirmed[:] = True
    return table


def look(positions, camera=0, before_ns=0):
    return camera, detections(PERIOD_NS - before_ns, positions, sigma=0.2)


def together(images):
    cameras, rows = [each for each, _ in images], [each for _, each in images]
    return Batch(rows, cameras, PERIOD_NS, CONFIG)


def assigned(table, images, config=CONFIG.association):
    """Return each image's pairs, track: place in the image, and the updated states."""
    batch = together(images)
    joint = JointAssociation(table, batch, config)
    mean, covariance = updated(table.mean, table.covariance, joint.solve())
    first = np.searchsorted(batch.image, np.arange(len(images)))
    pairs = [{} for _ in images]
    for track, row in zip(*joint.pairs()):
        pairs[batch.image[row]][int(track)] = int(row - first[batch.image[row]])
    return pairs, mean, covariance


def test_where_no_pair_is_in_doubt_the_update_is_the_filters_one_after_the_other():
    table = tracks([[0.0, 0.0], [4.0, 0.0]])
    seen = [look([[0.1, 0.2], [4.1, 0.0]]), look([[0.0, 0.1]], 1, before_ns=30_000_000)]
    _, mean, covariance = assigned(table, seen, SURE)
    expected = table.mean.copy(), table.covariance.copy()
    for each in (together([one]) for one in seen):
        rows = np.arange(len(each.position))
        matrix = position_matrix(each.seconds[0])
        innovation = each.position - expected[0][rows] @ matrix.T
        expected[0][rows], expected[1][rows] = update(
            expected[0][rows], expected[1][rows], innovation, each.noise, matrix
        )
    np.testing.assert_allclose(mean, expected[0], atol=1e-6)
    np.testing.assert_allclose(covariance, expected[1], atol=1e-6)


def test_the_others_correct_an_image_that_prediction_alone_misleads():
    table = tracks([[0.0, 0.0], [0.7, 0.0]])
    moved = [[0.45, 0.0], [1.15, 0.0]]
    clear = [look([place], camera) for camera, place in ((1, moved[0]), (2, moved[1]))]
    alone, *_ = assigned(table, [look(moved[:1])])
    helped, *_ = assigned(table, [look(moved[:1]), *clear, look(moved, 3)])
    assert alone[0] == {1: 0}
    assert helped[0] == {0: 0}


def test_a_doubtful_pair_moves_its_track_less():
    seen = [look([[0.2, 0.0]])]
    _, clear, sure = assigned(tracks([[0.0, 0.0]]), seen)
    _, doubtful, unsure = assigned(tracks([[0.0, 0.0], [0.45, 0.0]]), seen)
    assert 0 < doubtful[0, 0] < 0.8 * clear[0, 0]
    assert np.trace(unsure[0]) > np.trace(sure[0])


@pytest.mark.parametrize('seed', range(5))
def test_the_order_of_the_cameras_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 2, (5, 2))
    table = tracks(places)
    batch = [look(places + rng.normal(0, 0.2, (5, 2)), camera) for camera in range(4)]
    pairs, mean, _ = assigned(table, batch)
    backwards, again, _ = assigned(table, batch[::-1])
    assert pairs == backwards[::-1]
    np.testing.assert_allclose(mean, again, atol=1e-9)


def test_an_image_without_detections_and_no_tracks_are_no_trouble():
    pairs, mean, _ = assigned(tracks([[0.0, 0.0]]), [look([]), look([[9.0, 9.0]], 1)])
    assert pairs == [{}, {}]
    np.testing.assert_array_equal(mean[:, :2], [[0.0, 0.0]])
    assert assigned(tracks(np.empty((0, 2))), [look([[0.0, 0.0]])])[0] == [{}]
