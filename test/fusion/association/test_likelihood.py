"""What a pair of a track and a detection costs beside its distance."""

import numpy as np

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.association.likelihood import (
    RARELY_FALSE,
    TENTATIVE_COST,
    UNWATCHED_NS,
    cost_parts,
    prior_costs,
)
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE

CONFIG = JointAssociationConfig()


def scene(**columns):
    """Return two tracks, 5 and 9, detections of camera 1, and all pairs."""
    table = TrackTable.blank(2, 2)
    table.track_id[:] = 5, 9
    table.confirmed[:] = True
    count = len(next(iter(columns.values())))
    seen = detections(PERIOD_NS, np.zeros((count, 2)), **columns)
    fusion = JointConfig()
    batch = Batch([seen], [1], PERIOD_NS, fusion)
    return table, batch, *np.indices((2, count)).reshape(2, -1)


def parts(*scene, config=CONFIG):
    """Return the (tracks, detections) costs by what speaks."""
    return {name: cost.reshape(2, -1) for name, cost in cost_parts(*scene, config).items()}


def test_a_track_that_is_not_confirmed_costs_more():
    given = scene(score=[1.0])
    given[0].confirmed[1] = False
    np.testing.assert_array_equal(parts(*given)['doubt'], [[0], [TENTATIVE_COST]])


def test_false_detections_are_rare_by_a_camera_s_own_tracker():
    given = scene(local_id=[0, 1])
    given[0].seen_ns[:] = PERIOD_NS
    usual, rare = 2 * np.log(2 * np.pi * CONFIG.false_density * np.array([1, RARELY_FALSE]))
    np.testing.assert_allclose(parts(*given)['clutter'], [[usual, rare], [usual, rare]])


def test_whom_nobody_has_looked_for_a_detection_is_rather_than_nobody():
    """One seen just now, one not seen for long, one whom cameras have missed."""
    given = scene(score=[1.0])
    for silent_ns, missed, share in (
        (UNWATCHED_NS, 0.0, 1.0),
        (UNWATCHED_NS + 1, 0.0, RARELY_FALSE),
        (UNWATCHED_NS + 1, 0.1, 1.0),
    ):
        given[0].seen_ns[:], given[0].missed[:] = PERIOD_NS - silent_ns, missed
        expected = 2 * np.log(2 * np.pi * CONFIG.false_density * share)
        np.testing.assert_allclose(parts(*given)['clutter'], [[expected], [expected]])


def test_colours_cost_what_they_differ_by_beyond_the_usual():
    """Half in common: a Bhattacharyya coefficient of one half, a squared distance of one half."""
    own, other = np.zeros((2, TEMPLATE_SIZE), np.float32)
    own[[0, 1]], other[[1, 2]] = 0.5, 0.5
    given = scene(template=[own, other, np.zeros(TEMPLATE_SIZE)])
    given[0].template[0] = own
    weight, usual = CONFIG.appearance_weight, CONFIG.usual_difference
    np.testing.assert_allclose(
        parts(*given)['appearance'], [[-weight * usual, weight * (0.5 - usual), 0], [0, 0, 0]]
    )


def test_a_pair_costs_the_sum():
    given = scene(local_id=[0, 3], template=np.eye(2, TEMPLATE_SIZE))
    given[0].template[:] = np.eye(2, TEMPLATE_SIZE)
    given[0].confirmed[0] = False
    expected = sum(cost_parts(*given, CONFIG).values())
    np.testing.assert_allclose(prior_costs(*given, CONFIG), expected)
