from itertools import permutations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.tracking.association import assign, mahalanobis, pair_probabilities


def best_sum(cost, limit):
    """Try every partial one-to-one assignment."""
    rows, columns = cost.shape
    slots = [*range(columns), *[None] * rows]
    return min(
        sum(cost[row, column] - limit for row, column in enumerate(chosen) if column is not None)
        for chosen in permutations(slots, rows)
    )


@settings(deadline=None)
@given(
    rows=st.integers(0, 4),
    columns=st.integers(0, 4),
    limit=st.sampled_from([0.0, 5.0]),
    seed=st.integers(0, 10**6),
)
def test_assignment_is_the_cheapest_of_all(rows, columns, limit, seed):
    rng = np.random.default_rng(seed)
    cost = rng.normal(limit, 3, (rows, columns))
    cost[rng.random(cost.shape) < 0.3] = np.inf
    first, second = assign(cost, np.zeros(rows, int), limit)
    assert len(set(first)) == len(first)
    assert len(set(second)) == len(second)
    assert (cost[first, second] < limit).all()
    finite = np.where(np.isfinite(cost), cost, 1e6)
    np.testing.assert_allclose((cost[first, second] - limit).sum(), best_sum(finite, limit))


def test_nothing_to_assign_gives_nothing():
    for shape in [(0, 0), (0, 3), (3, 0)]:
        rows, columns = assign(np.zeros(shape), np.zeros(shape[0], int))
        assert len(rows) == len(columns) == 0


def test_mahalanobis_is_the_textbook_one():
    rng = np.random.default_rng(1)
    spread = rng.normal(size=(5, 2, 2))
    covariance = spread @ spread.swapaxes(1, 2) + np.eye(2)
    predicted, measured = rng.normal(size=(2, 2)), rng.normal(size=(3, 2))
    squared, log_determinant = mahalanobis(predicted, covariance[:2], measured, covariance[2:])
    for row in range(2):
        for column in range(3):
            total = covariance[row] + covariance[2 + column]
            gap = measured[column] - predicted[row]
            expected = gap @ np.linalg.solve(total, gap)
            np.testing.assert_allclose(squared[row, column], expected)
            np.testing.assert_allclose(log_determinant[row, column], np.log(np.linalg.det(total)))


def test_pair_probabilities_share_rows_and_columns():
    likelihood = np.array([[8.0, 0.0], [1.0, 3.0]])
    expected = np.array([[8 / 10, 0.0], [1 / 13, 3 / 5]])
    one_part = np.zeros(2, int)
    np.testing.assert_allclose(pair_probabilities(likelihood, one_part), expected)
    assert pair_probabilities(np.zeros((0, 3)), np.zeros(0, int)).shape == (0, 3)


@settings(deadline=None)
@given(sizes=st.lists(st.integers(0, 4), max_size=4), seed=st.integers(0, 10**6))
def test_parts_are_assigned_as_if_each_were_alone(sizes, seed):
    rng = np.random.default_rng(seed)
    part = np.repeat(np.arange(len(sizes)), sizes)
    cost = rng.normal(0, 3, (len(part), 5))
    rows, columns = assign(cost, part)
    probability = pair_probabilities(np.exp(-cost), part)
    for each in np.unique(part):
        mine = part == each
        alone_rows, alone_columns = assign(cost[mine], part[mine])
        assert list(rows[mine[rows]] - np.argmax(mine)) == list(alone_rows)
        assert list(columns[mine[rows]]) == list(alone_columns)
        alone = pair_probabilities(np.exp(-cost[mine]), part[mine])
        np.testing.assert_allclose(probability[mine], alone)
