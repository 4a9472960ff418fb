import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mctrack_experiments.papers.covering.assignment import (
    UNASSIGNED,
    BestPerSensor,
    best,
    compared,
    cost_of,
    flagged,
    recorded,
)
from mctrack_experiments.papers.covering.code_cost import METHOD, as_in_the_code, code_cost
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.update.update import ASSOCIATIONS

GATE = UNASSIGNED['covering_text']


@st.composite
def ticks(draw, images=2, tracks=4, detections=3):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    allowed = rng.random((images, tracks, detections)) < draw(st.sampled_from([0.4, 1.0]))
    image, track, column = map(np.ascontiguousarray, np.nonzero(allowed))
    slot = np.unique(image * tracks + track, return_inverse=True)[1]
    likelihood = np.exp(-rng.uniform(0, GATE, len(slot)) / 2)
    return Pairs(track, image * detections + column, slot, likelihood, image)


def least(pairs, rows):
    """Try every assignment of the tracks of one image: slow and obvious."""
    costs = []
    choices = [
        [None, *rows[pairs.slot[rows] == slot].tolist()] for slot in np.unique(pairs.slot[rows])
    ]
    for each in itertools.product(*choices):
        chosen = [row for row in each if row is not None]
        if len(set(pairs.detection[chosen].tolist())) == len(chosen):
            costs.append(sum(cost_of(pairs, chosen)) + GATE * (len(each) - len(chosen)))
    return min(costs)


def total(pairs, rows, chosen):
    return cost_of(pairs, chosen).sum() + GATE * (len(np.unique(pairs.slot[rows])) - len(chosen))


@given(ticks())
def test_the_optimum_costs_no_more_than_any_assignment(pairs):
    for rows in flagged(pairs):
        found = rows[best(pairs, rows, GATE)]
        assert len(set(pairs.detection[found].tolist())) == len(found)
        assert total(pairs, rows, found) == pytest.approx(least(pairs, rows))


@given(ticks())
def test_the_exchange_costs_no_less_than_the_optimum(pairs):
    given_to = compared([pairs], 'covering_text')
    assert 1.0 - 1e-9 <= given_to.cost_ratio <= given_to.largest_ratio + 1e-9
    assert given_to.proposals <= given_to.bound
    assert given_to.worse <= given_to.contested <= given_to.images


@given(ticks())
def test_the_best_assignment_stays_with_the_primary_sensors(pairs):
    chosen = BestPerSensor().probabilities(pairs) > 0
    assert len(set(pairs.track[chosen].tolist())) == chosen.sum()
    assert (
        chosen[np.setdiff1d(np.arange(len(chosen)), np.concatenate([[0], *flagged(pairs)]))].sum()
        == 0
    )


def test_recording_ends_with_the_block():
    usual = ASSOCIATORS[METHOD]
    empty = np.empty(0, np.int64)
    with recorded() as kept:
        ASSOCIATORS[METHOD]().probabilities(Pairs(empty, empty, empty, np.empty(0), empty))
    assert len(kept) == 1
    assert ASSOCIATORS[METHOD] is usual


def test_the_codes_cost_looks_at_distance_and_colours():
    difference = np.array([0.8, 0.1])
    cost = code_cost(np.array([0.2, 0.3]), difference)
    np.testing.assert_allclose(cost, [0.7 * 10 + 0.3 * 80, 0.7 * 15 + 0.3 * 10])
    far = code_cost(np.array([2.2, 2.2]), difference)
    assert np.isfinite(far).tolist() == [False, True]


@pytest.mark.parametrize('wanted', [False, True])
def test_the_codes_cost_ends_with_the_block(wanted):
    usual = ASSOCIATIONS[METHOD]
    with as_in_the_code(wanted):
        assert (ASSOCIATIONS[METHOD] is not usual) == wanted
    assert ASSOCIATIONS[METHOD] is usual
