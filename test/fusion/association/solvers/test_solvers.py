import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.association.solvers.belief import beliefs

CERTAIN = {'gnn', 'nearest', 'covering_graph'}
SHARES_DETECTIONS = {'nearest'}


def pairs_of(allowed, likelihood):
    """Return the pairs of a (slots, detections) mask, and their (slots, detections) indices."""
    slot, detection = map(np.ascontiguousarray, np.nonzero(allowed))
    numbered = np.unique(slot, return_inverse=True)[1]
    image = np.zeros(len(slot), np.int64)
    return Pairs(slot, detection, numbered, np.ascontiguousarray(likelihood[allowed]), image)


@st.composite
def graphs(draw, largest=4):
    slots, detections = draw(st.integers(1, largest)), draw(st.integers(1, largest))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    allowed = rng.random((slots, detections)) < draw(st.sampled_from([0.3, 0.6, 1.0]))
    return pairs_of(allowed, np.exp(rng.normal(0.0, draw(st.sampled_from([1, 4])), allowed.shape)))


def beliefs_of(pairs):
    return beliefs(pairs.slot, pairs.detection, pairs.likelihood)


def joint_assignments(pairs):
    """Yield the pairs of every joint assignment, one after the other."""
    slots = np.unique(pairs.slot)
    choices = [[None, *np.flatnonzero(pairs.slot == slot).tolist()] for slot in slots]
    for each in itertools.product(*choices):
        chosen = [pair for pair in each if pair is not None]
        if len(set(pairs.detection[chosen].tolist())) == len(chosen):
            yield chosen


def marginals(pairs):
    """Sum over all joint assignments: slow and obvious."""
    total, probability = 0.0, np.zeros(len(pairs.slot))
    for chosen in joint_assignments(pairs):
        weight = np.prod(pairs.likelihood[chosen])
        total += weight
        probability[chosen] += weight
    return probability / total


@pytest.fixture(params=sorted(ASSOCIATORS))
def name(request):
    return request.param


@pytest.fixture
def associator(name):
    return ASSOCIATORS[name]()


@pytest.mark.parametrize('name', sorted(ASSOCIATORS))
@given(pairs=graphs(6))
def test_probabilities_of_a_slot_sum_to_one_at_most(name, pairs):
    probability = ASSOCIATORS[name]().probabilities(pairs)
    assert probability.shape == pairs.slot.shape
    assert ((probability >= 0) & (probability <= 1)).all()
    assert (np.bincount(pairs.slot, probability) <= 1 + 1e-9).all()
    if name not in SHARES_DETECTIONS:
        assert (np.bincount(pairs.detection, probability) <= 1 + 1e-6).all()
    if name in CERTAIN:
        assert np.isin(probability, (0.0, 1.0)).all()


@pytest.mark.parametrize('name', sorted(ASSOCIATORS))
@given(pairs=graphs(5), seed=st.integers(0, 1000))
def test_the_detections_order_does_not_matter(name, pairs, seed):
    names = np.random.default_rng(seed).permutation(pairs.detection.max(initial=0) + 1)
    order = np.lexsort((names[pairs.detection], pairs.slot))
    permuted = Pairs(
        pairs.track[order],
        names[pairs.detection][order],
        pairs.slot,
        pairs.likelihood[order],
        pairs.image,
    )
    first = ASSOCIATORS[name]().probabilities(pairs)
    np.testing.assert_allclose(
        ASSOCIATORS[name]().probabilities(permuted), first[order], atol=1e-4
    )


@given(graphs())
def test_jpda_sums_over_all_joint_assignments(pairs):
    probability = ASSOCIATORS['jpda']().probabilities(pairs)
    np.testing.assert_allclose(probability, marginals(pairs), atol=1e-9)


@given(graphs())
def test_gnn_is_the_likeliest_joint_assignment(pairs):
    def likelihood(chosen):
        return np.log(pairs.likelihood[chosen]).sum()

    best = max(map(likelihood, joint_assignments(pairs)))
    chosen = np.flatnonzero(ASSOCIATORS['gnn']().probabilities(pairs))
    assert likelihood(chosen) == pytest.approx(best)


def test_belief_propagation_is_exact_without_loops_and_near_with_them():
    chain = np.array([[1, 1, 0], [0, 1, 1], [0, 0, 1]], bool)
    likelihood = np.array([[3.0, 1.0, 0], [0, 0.5, 9.0], [0, 0, 2.0]])
    pairs = pairs_of(chain, likelihood)
    np.testing.assert_allclose(beliefs_of(pairs), marginals(pairs), atol=1e-6)
    crowd = pairs_of(np.ones((3, 3), bool), np.exp(np.random.default_rng(1).normal(size=(3, 3))))
    np.testing.assert_allclose(beliefs_of(crowd), marginals(crowd), atol=0.05)


def test_large_clusters_are_left_to_belief_propagation():
    rng = np.random.default_rng(0)
    of_two_clusters = np.add.outer(np.arange(24), np.arange(24)) % 2 == 0
    pairs = pairs_of(of_two_clusters, np.exp(rng.normal(size=(24, 24))))
    joint = ASSOCIATORS['jpda']().probabilities(pairs)
    np.testing.assert_allclose(joint, beliefs_of(pairs), rtol=1e-12)


def test_certain_pairs_stay_certain_however_large_their_likelihood(associator):
    pairs = pairs_of(np.eye(2, dtype=bool), np.full((2, 2), 1e200))
    np.testing.assert_allclose(associator.probabilities(pairs), 1.0, atol=1e-6)


def test_no_pairs_are_no_trouble(associator):
    assert associator.probabilities(pairs_of(np.zeros((2, 2), bool), np.ones((2, 2)))).size == 0


def test_what_tells_nobody_apart_is_shared_by_jpda_and_weighs_little_otherwise():
    pairs = pairs_of(np.ones((2, 1), bool), np.full((2, 1), 1e6))
    shares = {name: ASSOCIATORS[name]().probabilities(pairs) for name in ASSOCIATORS}
    np.testing.assert_allclose(shares['jpda'], 0.5, atol=1e-3)
    np.testing.assert_allclose(sorted(shares['weighed_gnn']), [0, 0.5], atol=1e-3)
    assert sorted(shares['gnn']) == [0, 1]
    assert list(shares['nearest']) == [1, 1]


def test_no_associator_looks_beyond_its_pairs():
    """Compiled code would read there and say nothing: uncompiled, numpy refuses to."""
    command = [sys.executable, '-m', 'pytest', '-q', '-k', 'sum_to_one']
    done = subprocess.run(
        [*command, '-p', 'no:cacheprovider', Path(__file__).parent],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env={**os.environ, 'NUMBA_DISABLE_JIT': '1', 'MCTRACK_REQUIRE_DATA': ''},
    )
    assert not done.returncode, done.stdout
