"""Algorithm 1 of the likelihood-grid paper, with the corrections of its gaps."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.fusion.likelihood_grid.config import TargetsConfig
from mctrack_ros.fusion.likelihood_grid.targets import (
    Measured,
    assigned,
    begun,
    matched,
    predicted,
)

PERIOD_S = 0.04
CONFIG = TargetsConfig(gate=0.7, confirm_time=0.2, keep_time=0.4)


def people(places, colours=None):
    places = np.reshape(places, (-1, 2)).astype(float)
    template = np.zeros((len(places), 48)) if colours is None else np.eye(48)[colours]
    return Measured(places, np.tile(0.01 * np.eye(2), (len(places), 1, 1)), template)


def targets(places, colours=None):
    return begun(people(places, colours), 1, 0, PERIOD_S)


def step(before, measured):
    return matched(predicted(before, PERIOD_S), measured, PERIOD_S, CONFIG)


PLACES = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), max_size=4)


@settings(max_examples=100, deadline=None)
@given(PLACES, PLACES)
def test_the_most_pairs_within_the_gate_with_the_least_distance(at, seen):
    one, other = targets(at), people(seen)
    chosen = assigned(one, other, 0.7)
    distance = np.linalg.norm(one.mean[:, None, :2] - other.position[None], axis=2)
    best = (0, 0.0)
    size = min(len(at), len(seen))
    for count in range(size + 1):
        for rows in itertools.combinations(range(len(at)), count):
            for columns in itertools.permutations(range(len(seen)), count):
                own = distance[list(rows), list(columns)] if count else np.zeros(0)
                if (own <= 0.7).all():
                    best = max(best, (count, -float(own.sum())))
    pairs = np.flatnonzero(chosen >= 0)
    assert len(set(chosen[pairs].tolist())) == len(pairs) == best[0]
    np.testing.assert_allclose(distance[pairs, chosen[pairs]].sum(), -best[1], atol=1e-9)


def test_pairs_beyond_the_gate_are_none_on_either_side():
    assert assigned(targets([[0, 0]]), people([[0.71, 0]]), 0.7).tolist() == [-1]
    assert assigned(targets([[0, 0]]), people([]), 0.7).tolist() == [-1]


def test_a_new_target_dies_at_one_miss():
    after = step(targets([[0, 0]]), people([]))
    assert after.counter_s.tolist() == [0.0]


def test_a_target_without_a_measurement_counts_down_where_there_are_fewer_of_those():
    before = targets([[0, 0], [3, 0]])
    for _ in range(5):
        before = step(before, people([[0, 0], [3, 0]]))
    after = step(before, people([[0, 0]]))
    np.testing.assert_allclose(after.counter_s - before.counter_s, [PERIOD_S, -PERIOD_S])
    assert after.measurement.tolist() == [0, -1]


def test_the_counter_stops_at_its_maximum_and_runs_down_in_that_time():
    before = targets([[0, 0]])
    for _ in range(100):
        before = step(before, people([[0, 0]]))
    np.testing.assert_allclose(before.counter_s, [0.4])
    missed = 0
    while before.counter_s[0] > 1e-6:
        before, missed = step(before, people([])), missed + 1
    assert missed == 10


def test_a_target_is_confirmed_once_it_has_been_measured_for_so_long():
    before, said = targets([[0, 0]]), []
    for _ in range(6):
        before = step(before, people([[0, 0]]))
        said += before.confirmed.tolist()
    assert said == [False, False, False, True, True, True]
    assert step(before, people([])).confirmed.tolist() == [True]


def test_it_follows_who_walks():
    before = targets([[0, 0]])
    for index in range(50):
        before = step(before, people([[0.05 * (index + 1), 0]]))
    np.testing.assert_allclose(before.mean[0], [2.5, 0, 1.25, 0], atol=0.05)


def test_who_looks_alike_goes_together_though_others_are_nearer():
    before = targets([[0, 0], [0.3, 0]], [3, 7])
    after = step(before, people([[0.02, 0], [0.28, 0]], [7, 3]))
    assert after.measurement.tolist() == [1, 0]
    assert step(before, people([[0.02, 0], [0.28, 0]])).measurement.tolist() == [0, 1]


def test_colours_are_learned_only_while_nobody_is_near():
    near = step(targets([[0, 0], [0.3, 0]], [3, 7]), people([[0, 0], [0.3, 0]], [4, 8]))
    np.testing.assert_array_equal(near.template, np.eye(48)[[3, 7]])
    apart = step(targets([[0, 0], [3, 0]], [3, 7]), people([[0, 0], [3, 0]], [4, 8]))
    assert (apart.template[[0, 1], [4, 8]] > 0).all()
    np.testing.assert_allclose(apart.template.sum(axis=1), 1)
