import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays

from mctrack_ros.perception.silhouettes.features import ComparisonConfig, Shapes, stacked
from mctrack_ros.perception.silhouettes.matching.duplicates import (
    secure_silhouettes,
    settled,
    without_parts,
    without_swollen,
    without_transient_duplicates,
)

WEIGHTS = ComparisonConfig().weights()


@given(arrays(np.bool_, (5, 4)), arrays(np.bool_, 5))
def test_transient_objects_give_way_to_established_ones_and_only_they(match, established):
    left = without_transient_duplicates(match, established)
    secure = secure_silhouettes(match, established)
    assert (left[established] == match[established]).all()
    for row in np.flatnonzero(~established):
        assert (left[row] == (match[row] & ~secure)).all()


@given(
    arrays(np.bool_, (4, 3)),
    arrays(np.float64, (7, 21), elements={'min_value': 0, 'max_value': 9}),
)
def test_once_settled_a_silhouette_has_one_object_and_none_lost_all_of_theirs(match, vector):
    objects = Shapes(vector[:4], np.zeros((4, 4)))
    silhouettes = Shapes(vector[4:], np.zeros((3, 4)))
    left = settled(objects, silhouettes, match, WEIGHTS)
    assert (left <= match).all()
    assert (left.any(axis=0) == match.any(axis=0)).all()
    assert (left.sum(axis=0) <= 1).all()


@pytest.mark.parametrize(
    ('area', 'alone_s', 'kept'),
    [
        ([500, 100], [9.0, 0.2], [True, False]),  # a part that came off at the edge
        ([500, 100], [9.0, 3.0], [True, True]),  # two bodies
        ([500, 4000], [9.0, 0.2], [True, True]),  # a car behind a pedestrian is no part of him
        ([500, 100], [0.2, 0.1], [True, False]),  # nobody is known: the older stays
    ],
)
def test_what_was_never_seen_alone_is_a_part_of_who_was(area, alone_s, kept):
    match, established = np.ones((2, 1), np.bool_), np.ones(2, np.bool_)
    left = without_parts(match, established, np.array(area, float), np.array(alone_s), 1.0)
    assert left[:, 0].tolist() == kept


def test_a_pedestrian_does_not_become_a_car():
    match = np.ones((2, 2), np.bool_)
    left = without_swollen(match, np.array([True, False]), np.array([True, False]))
    assert left.tolist() == [[False, True], [True, True]]


def test_nothing_is_settled_of_nothing():
    nothing = Shapes(np.zeros((0, 21)), np.zeros((0, 4)))
    assert settled(nothing, stacked(nothing), np.zeros((0, 0), np.bool_), WEIGHTS).shape == (0, 0)
