import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.perception.silhouettes.features import ComparisonConfig, Shapes, stacked
from mctrack_ros.perception.silhouettes.foreground.components import shapes_of
from mctrack_ros.perception.silhouettes.matching.match import (
    MatchConfig,
    gaps,
    naive_matches,
    valid_matches,
)

WEIGHTS = ComparisonConfig(form_weight=1.0, grey_weight=1.0, place_weight=0.0).weights()
PRINTED = MatchConfig(radius_px=80.0, distance='centroids', only_valid=False)
BOXES = st.tuples(*(st.integers(0, 60) for _ in range(2)), *(st.integers(1, 30) for _ in range(2)))


def block(left, top, width, height, grey=100):
    """Return the shape of a rectangle of one grey."""
    y, x = np.mgrid[top : top + height, left : left + width].reshape(2, -1)
    return shapes_of(x, y, np.full(len(x), grey, np.uint8))


def matched(objects, silhouettes, config=PRINTED):
    valid = valid_matches(objects, silhouettes, config)
    return naive_matches(objects, silhouettes, valid, config, WEIGHTS)


def test_silhouettes_within_the_radius_are_valid():
    objects = block(100, 100, 20, 60)
    silhouettes = stacked(block(180, 100, 20, 60), block(181, 100, 20, 60))
    assert valid_matches(objects, silhouettes, PRINTED).tolist() == [[True, False]]


@given(BOXES, BOXES)
def test_gaps_between_boxes_are_those_of_their_pixels(one, other):
    (left, top, width, height), (x, y, wide, high) = one, other
    columns = [abs(a - b) for a in range(left, left + width + 1) for b in range(x, x + wide + 1)]
    rows = [abs(a - b) for a in range(top, top + height + 1) for b in range(y, y + high + 1)]
    found = gaps(np.array([one], float), np.array([other], float))
    assert found.tolist() == [[[min(columns), min(rows)]]]


def test_an_object_takes_the_silhouette_that_looks_most_like_it():
    objects = stacked(block(0, 0, 20, 60, 50), block(30, 0, 50, 30, 200))
    silhouettes = stacked(block(28, 2, 52, 29, 200), block(2, 1, 20, 61, 50))
    assert matched(objects, silhouettes).tolist() == [[False, True], [True, False]]


def test_one_silhouette_may_be_matched_to_several_objects():
    objects = stacked(block(0, 0, 20, 60), block(25, 0, 20, 60))
    assert matched(objects, block(10, 0, 22, 60)).tolist() == [[True], [True]]


def test_as_printed_the_best_may_be_out_of_reach_and_then_there_is_none():
    objects = block(0, 0, 20, 60, 50)
    silhouettes = stacked(block(10, 0, 30, 30, 200), block(300, 0, 20, 60, 50))
    assert not matched(objects, silhouettes).any()
    assert matched(objects, silhouettes, MatchConfig(only_valid=True)).tolist() == [[True, False]]


def test_nothing_matches_nothing():
    one = block(0, 0, 2, 2)
    nothing = Shapes(one.vector[:0], one.box[:0])
    assert matched(nothing, one).shape == (0, 1)
    assert matched(one, nothing).shape == (1, 0)
