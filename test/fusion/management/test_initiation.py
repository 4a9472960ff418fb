"""Where tracks begin, from the detections that no track took."""

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.management.initiation import (
    CROWD_EVIDENCE,
    CROWD_M,
    MOST_STARTS,
    MOST_TOGETHER,
    ask_more,
    new_tracks,
    with_room,
)
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA, motion_of
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE, Detections

CONFIG = JointConfig()


def looks_of(images):
    """Return images, one a camera, of places and their covariances."""
    rows = [
        Detections.build(
            PERIOD_NS,
            position=np.column_stack([places, np.zeros(len(places))]),
            covariance=covariance,
            **columns,
        )
        for places, covariance, columns in images
    ]
    cameras = range(len(rows))
    return Batch(rows, cameras, PERIOD_NS, CONFIG)


def begun(images, next_id=1):
    batch = looks_of(images)
    rows = np.arange(len(batch.position))
    cameras = len(images)
    motion = motion_of(CONFIG.motion)
    return batch, new_tracks(batch, rows, PERIOD_NS, next_id, cameras, CONFIG, motion)


def image(places, sigma=0.3, **columns):
    places = np.array(places, float).reshape(-1, 2)
    return places, np.tile(sigma**2 * np.eye(2), (len(places), 1, 1)), columns


def test_a_track_begins_at_the_weighted_mean_of_its_detections_at_rest():
    rng = np.random.default_rng(0)
    root = rng.normal(0, 0.3, (3, 1, 2, 2))
    covariance = root @ root.swapaxes(-1, -2) + 0.05 * np.eye(2)
    images = [(rng.normal(5, 0.1, (1, 2)), one, {}) for one in covariance]
    batch, table = begun(images, next_id=17)
    weight = np.linalg.inv(batch.noise)
    spread = np.linalg.inv(weight.sum(axis=0))
    place = spread @ np.einsum('nij,nj->i', weight, batch.position)
    np.testing.assert_allclose(table.mean, [[*place, 0, 0]])
    expected = np.zeros((4, 4))
    expected[:2, :2] = spread
    expected[2:, 2:] = INITIAL_SPEED_SIGMA**2 * np.eye(2)
    np.testing.assert_allclose(table.covariance, expected[None], atol=1e-12)
    assert (table.track_id[0], table.cameras[0]) == (17, 0b111)
    stamps = table.first_ns, table.seen_ns, table.kept_ns, table.seen_by_ns
    assert all((each == PERIOD_NS).all() for each in stamps)


def starts(*images):
    """Return where tracks begin, x rounded to 5 cm, and how many cameras each has."""
    _, table = begun(images)
    assert table.track_id.tolist() == list(range(1, len(table) + 1))
    return [
        (round(20 * x) / 20, int(cameras).bit_count())
        for x, cameras in zip(table.mean[:, 0].tolist(), table.cameras)
    ]


def test_the_nearest_of_different_cameras_begin_together_one_of_each():
    one, other = image([[0, 0], [0.5, 0]]), image([[0.4, 0], [9, 0]])
    assert starts(one, other) == [(0.0, 1), (0.45, 2), (9.0, 1)]
    assert starts(one, other, image([[0.1, 0]])) == [(0.05, 2), (0.45, 2), (9.0, 1)]
    chain = [image([[x, 0]]) for x in (0.0, 0.9, 0.3)]
    assert starts(*chain) == [(0.4, 3)]


@pytest.mark.parametrize(('gap', 'sigma', 'count'), [
    (1.45, 1.0, 1), (1.55, 1.0, 2), (1.1, 0.1, 1), (1.25, 0.1, 2),
])  # fmt: skip
def test_too_far_apart_or_too_sure_to_be_one_they_begin_two(gap, sigma, count):
    """1.5 m, and where each is known to .1 m and .2 m more: 3.7 x .316 m = 1.17 m."""
    assert len(starts(image([[0, 0]], sigma), image([[gap, 0]], sigma))) == count


def test_the_colours_are_those_of_the_first_camera_that_tells_them():
    colours = np.eye(3, TEMPLATE_SIZE, dtype=np.float32)
    images = [image([[0, 0]], template=colours[[row]]) for row in (1, 2)]
    nothing = image([[0, 0]], template=np.zeros((1, TEMPLATE_SIZE)))
    _, table = begun([nothing, *images])
    np.testing.assert_array_equal(table.template, colours[[1]])


def test_of_a_flood_each_camera_begins_as_many():
    """One has 40; the other two share what is left."""
    places = 20.0 * np.stack(np.mgrid[:20, :15], axis=-1).reshape(-1, 2)
    shift = [[0, 0], [7, 0], [0, 7]]
    few = image(places[:40] + shift[1])
    _, table = begun([image(places + shift[0]), few, image(places + shift[2])])
    told = [int((table.cameras == 1 << camera).sum()) for camera in range(3)]
    assert told == [(MOST_STARTS - 40) // 2, 40, (MOST_STARTS - 40) // 2]


def tracks(places):
    table = TrackTable.blank(len(places), 1)
    table.mean[:, :2] = places
    table.track_id[:] = np.arange(len(places)) + 1
    table.confirmed[:] = True
    return table


def test_what_begins_very_near_a_confirmed_track_needs_more_evidence():
    known = tracks([[0, 0], [50, 0], [80, 0]])
    known.confirmed[2] = False
    fresh = tracks([[50 + gap, 0] for gap in (CROWD_M - 0.01, CROWD_M + 0.01)])
    fresh = fresh.extended(tracks([[80.1, 0]]))
    ask_more(fresh, known)
    assert fresh.evidence.tolist() == [-CROWD_EVIDENCE, 0, 0]


@pytest.mark.parametrize('seed', range(5))
def test_who_begins_beside_others_is_near_one_there_or_one_before(seed):
    known, fresh = np.random.default_rng(seed).uniform(0, 6, (2, 8, 2))
    kept, beside = with_room(tracks(fresh), tracks(known), CONFIG)
    gaps = [
        np.linalg.norm(np.vstack([known, fresh[:row]]) - fresh[row], axis=1) for row in range(8)
    ]
    assert len(kept) == 8
    assert beside.tolist() == [row for row, gap in enumerate(gaps) if gap.min() < CROWD_M]


def test_no_more_begin_than_there_is_room_for_and_none_in_a_dense_crowd():
    known = tracks([[0, 0], [10, 0]])
    fresh, beside = with_room(tracks([[5, 0], [0.5, 0], [5.5, 0], [9, 9]]), known, CONFIG)
    assert len(fresh) == 4
    assert beside.tolist() == [1, 2]
    small = JointConfig(management=ManagementConfig(most_tracks=5))
    assert with_room(tracks([[5, 0], [7, 0], [20, 0], [30, 0]]), known, small)[0].mean[
        :, 0
    ].tolist() == [5, 7, 20]
    assert len(with_room(tracks([[5, 0]]), tracks(np.zeros((6, 2))), small)[0]) == 0
    spot = np.zeros((MOST_TOGETHER + 3, 2))
    fresh, _ = with_room(tracks(np.vstack([spot, [[7, 7]]])), known, CONFIG)
    assert len(fresh) == MOST_TOGETHER
    assert fresh.mean[-1, 0] == 7
