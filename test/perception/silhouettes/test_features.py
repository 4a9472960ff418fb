import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mctrack_ros.perception.silhouettes.features import (
    AREA,
    HEIGHT,
    HISTOGRAM,
    NONE,
    SIZE,
    WIDTH,
    ComparisonConfig,
    best_matches,
    cost,
    stacked,
)
from mctrack_ros.perception.silhouettes.foreground.components import shapes_of

WEIGHTS = ComparisonConfig(form_weight=1.0, grey_weight=1.0, place_weight=0.0).weights()
COUNTS = st.integers(0, 30).map(float)


def vectors(count):
    return arrays(np.float64, st.tuples(st.integers(*count), st.just(SIZE)), elements=COUNTS)


def slow_cost(new, old):
    """Return the comparison as it is written, term by term."""
    return sum((a - b) / (a + b) for a, b in zip(new[:19], old[:19]) if a + b > 0)


def slow_best(target, candidates, allowed):
    """Return the winner of the tournament, candidate by candidate."""
    winner = NONE
    for index, candidate in enumerate(candidates):
        if not allowed[index]:
            continue
        if winner == NONE or (
            slow_cost(np.abs(target - candidate), np.abs(target - candidates[winner])) < 0
        ):
            winner = index
    return winner


@given(vectors((2, 2)))
def test_cost_changes_its_sign_when_new_and_old_change_places(pair):
    assert cost(pair[0], pair[1], WEIGHTS) == pytest.approx(-cost(pair[1], pair[0], WEIGHTS))
    assert cost(pair[0], pair[1], WEIGHTS) == pytest.approx(slow_cost(*pair))


def test_two_perfect_candidates_cost_the_same():
    nothing = np.zeros(SIZE)
    assert cost(nothing, nothing, WEIGHTS) == 0.0


def test_the_place_counts_only_where_it_has_a_weight():
    near, far = np.zeros(SIZE), np.zeros(SIZE)
    far[-2:] = 50.0
    assert cost(far, near, WEIGHTS) == 0.0
    assert cost(far, near, ComparisonConfig(place_weight=2.0).weights()) == 4.0


@given(vectors((0, 4)), vectors((0, 5)), st.integers(0, 2**20))
def test_best_matches_are_those_of_the_tournament_in_index_order(targets, candidates, bits):
    allowed = np.array(
        [bits >> index & 1 for index in range(len(targets) * len(candidates))], np.bool_
    ).reshape(len(targets), len(candidates))
    expected = [slow_best(target, candidates, row) for target, row in zip(targets, allowed)]
    assert best_matches(targets, candidates, allowed, WEIGHTS).tolist() == expected


@given(arrays(np.bool_, (12, 15)), arrays(np.uint8, (12, 15)), st.integers(1, 14))
def test_united_parts_are_the_shape_of_all_pixels(mask, grey, cut):
    y, x = np.nonzero(mask)
    left = x < cut
    if not left.any() or left.all():
        return
    whole = shapes_of(x, y, grey[y, x])
    parts = [shapes_of(x[part], y[part], grey[y[part], x[part]]) for part in (left, ~left)]
    united = stacked(*parts).united()
    assert np.allclose(united.vector, whole.vector)
    assert np.array_equal(united.box, whole.box)


def test_a_vector_holds_area_extent_and_pixels_by_grey():
    shape = shapes_of(np.array([3, 4, 4]), np.array([7, 7, 9]), np.array([0, 15, 255], np.uint8))
    vector = shape.vector[0]
    assert vector[[AREA, WIDTH, HEIGHT]].tolist() == [3, 2, 3]
    assert vector[HISTOGRAM].tolist() == [2] + [0] * 14 + [1]
    assert shape.box.tolist() == [[3, 7, 2, 3]]
    assert shape.centroid[0].tolist() == pytest.approx([11 / 3, 23 / 3])
