"""The product of the cameras' likelihoods and its maxima."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.fusion.likelihood_grid.grid import JointGrid
from mctrack_ros.interfaces import NO_EDGE, Likelihood

CELLS = 40
AXES = [(np.arange(CELLS) + 0.5) * side / CELLS for side in (6.0, 4.2)]
CENTRES = np.stack(np.meshgrid(*AXES), axis=-1).reshape(-1, 2)


def likelihood(places, unseen=(), height=-1.0, width=0.15):
    """Return what a camera tells that sees people as bumps."""
    position = np.column_stack([CENTRES, np.zeros(len(CENTRES))])
    told = np.full(len(CENTRES), NO_EDGE)
    for place in places:
        squared = ((CENTRES - place) ** 2).sum(axis=1) / width**2
        told = np.maximum(told, height - np.minimum(squared, 7.0) / 2)
    told[list(unseen)] = np.nan
    return Likelihood.build(0, position=position, log_likelihood=told)


def test_rows_and_columns_of_a_grid_are_told_by_its_cells():
    assert likelihood([]).shape == (CELLS, CELLS)
    assert Likelihood.build(0).shape == (0, 0)


def test_people_are_found_between_cells():
    people = np.array([[1.52, 1.31], [4.03, 3.02]])
    found = JointGrid([likelihood(people)] * 4).maxima(-3.0)
    gaps = np.linalg.norm(found.position[:, None] - people, axis=2)
    assert gaps.shape == (2, 2)
    assert gaps.min(axis=0).max() < 0.03


def test_a_place_that_one_camera_denies_is_less_likely():
    seen = [likelihood([[3.0, 2.0]])] * 3
    every = JointGrid([*seen, likelihood([[3.0, 2.0]])]).maxima(-4.5).likelihood.max()
    denied = JointGrid([*seen, likelihood([])]).maxima(-4.5).likelihood.max()
    assert denied == pytest.approx(every - 3.5 / 4, abs=0.1)


def test_a_camera_that_does_not_see_a_cell_says_nothing_of_it():
    seen = [likelihood([[3.0, 2.0]])] * 3
    blind = likelihood([], unseen=range(len(CENTRES)))
    np.testing.assert_allclose(JointGrid([*seen, blind]).mean, JointGrid(seen).mean)
    alone = JointGrid([seen[0], blind])
    assert (alone.mean == NO_EDGE).all()


def test_values_between_cells_are_interpolated():
    grid = JointGrid([likelihood([[3.0, 2.0]])] * 2)
    np.testing.assert_allclose(grid.at(CENTRES), grid.mean.ravel(), atol=1e-5)
    halfway = (CENTRES[820] + CENTRES[821]) / 2
    expected = grid.mean.ravel()[820:822].mean()
    np.testing.assert_allclose(grid.at(halfway[None]), expected, atol=1e-5)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.5, 5.5), st.floats(0.5, 3.7)), min_size=1, max_size=6),
    st.permutations(range(3)),
)
def test_maxima_are_apart_and_do_not_depend_on_the_order_of_cameras(people, order):
    told = [likelihood(people[index:]) for index in range(3)]
    found = JointGrid(told).maxima(-4.4).position
    gap = np.linalg.norm(found[:, None] - found, axis=2) + np.diag(np.full(len(found), 9.0))
    assert gap.min(initial=9.0) >= 0.2
    other = JointGrid([told[index] for index in order]).maxima(-4.4).position
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(other, axis=0), atol=1e-6)


def test_different_cells_are_refused():
    one = likelihood([])
    other = one.replace(position=one.position + np.float32(0.1))
    with pytest.raises(ValueError, match='different cells'):
        JointGrid([one, other])
