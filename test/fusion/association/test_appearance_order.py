import numpy as np

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.appearance_order import MOST, OVERLAPPED_SHARE, likeness_costs
from mctrack_ros.fusion.config import JointAssociationConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.reid.gallery import AppearanceSample, Gallery
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import TEMPLATE_SIZE

CONFIG = JointAssociationConfig(likeness_weight=2.0)
PORTRAITS = Gallery()
APART = [[0.0, 0.0, 1.0, 1.0], [10.0, 0.0, 1.0, 1.0]]
OVERLAPPED = [[0.0, 0.0, 1.0, 1.0], [0.5, 0.0, 1.0, 1.0]]


def colours(*people):
    """Return templates: half of each is common, half his own; nothing known of person 0."""
    template = np.zeros((len(people), TEMPLATE_SIZE), np.float32)
    for row, person in zip(template, people):
        if person:
            row[[0, person]] = 0.5
    return template


def tracks(*people):
    table = TrackTable.blank(len(people), 1)
    table.template[:] = colours(*people)
    table.confirmed[:] = True
    return table


def costs(table, *people, boxes=APART, template=None, config=CONFIG, gallery=PORTRAITS):
    """Return the (tracks, detections) costs of all pairs."""
    seen = detections(
        PERIOD_NS,
        np.zeros((len(people), 2)),
        box=boxes[: len(people)],
        template=colours(*people) if template is None else template,
    )
    batch = Batch([seen], [0], PERIOD_NS, JointConfig(), gallery)
    track, row = np.indices((len(table), len(people))).reshape(2, -1)
    is_known = table.template.any(axis=1)[track] & batch.is_described[row]
    return likeness_costs(table, batch, track, row, is_known, config).reshape(len(table), -1)


def test_to_be_like_another_costs_and_to_be_most_alike_is_free():
    cost = costs(tracks(1, 2), 1, 2)
    np.testing.assert_array_equal(np.diag(cost), 0.0)
    assert cost[0, 1] == cost[1, 0] > 2.0


def test_one_who_looks_like_nobody_near_costs_what_he_is_less_alike_than_the_best():
    alone = costs(tracks(1), 5)
    np.testing.assert_array_equal(alone, 0.0)


def test_what_is_partly_anothers_tells_less():
    own, other = colours(1, 2).astype(float)
    clean = costs(tracks(1, 2), 1, template=own[None].astype(np.float32))
    mixed = (0.6 * own + 0.4 * other)[None].astype(np.float32)
    assert 0.0 < costs(tracks(1, 2), 1, template=mixed)[1, 0] < clean[1, 0]


def test_where_boxes_overlap_it_costs_less():
    apart, overlapped = (costs(tracks(1, 2), 1, 2, boxes=each) for each in (APART, OVERLAPPED))
    np.testing.assert_allclose(overlapped, OVERLAPPED_SHARE * apart)


def test_it_never_costs_more_than_other_evidence_can_outweigh():
    sure = JointAssociationConfig(likeness_weight=1000.0)
    assert costs(tracks(1, 2), 1, 2, config=sure).max() == MOST


def test_whose_colours_are_not_known_is_neither_like_nor_unlike():
    np.testing.assert_array_equal(costs(tracks(0, 1), 2, 0)[0], 0.0)
    np.testing.assert_array_equal(costs(tracks(0, 1), 2, 0)[:, 1], 0.0)


def test_a_track_that_is_not_confirmed_takes_nothing_from_one_that_is():
    table = tracks(1, 2)
    table.confirmed[1] = False
    np.testing.assert_array_equal(costs(table, 2), 0.0)


def test_a_sure_portrait_counts_more_than_the_latest_template():
    gallery = Gallery()
    for name, person in ((1, 2), (2, 1)):
        gallery.learn(name, AppearanceSample(np.sqrt(colours(person)[0].astype(float)), 10.0))
    table = tracks(1, 2)
    table.track_id[:] = 1, 2
    cost = costs(table, 1, gallery=gallery)
    assert cost[0, 0] > 2.0
    assert cost[1, 0] == 0.0
