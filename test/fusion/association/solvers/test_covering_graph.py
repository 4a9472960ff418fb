import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.association.solvers.covering_graph import covering, exchange, flags


@st.composite
def ticks(draw, images=3, tracks=5, detections=4):
    """Return the pairs of several images, each with detections of its own."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    allowed = rng.random((images, tracks, detections)) < draw(st.sampled_from([0.2, 0.5, 1.0]))
    image, track, column = map(np.ascontiguousarray, np.nonzero(allowed))
    slot = np.unique(image * tracks + track, return_inverse=True)[1]
    likelihood = np.exp(rng.normal(0, 3, len(slot)))
    return Pairs(track, image * detections + column, slot, likelihood, image)


def cheapest_first(pairs, rows):
    """Take the best of all pairs, then the best of those left: slow and obvious."""
    chosen = []
    for row in sorted(rows.tolist(), key=lambda row: -pairs.likelihood[row]):
        if not any(
            pairs.slot[row] == pairs.slot[other] or pairs.detection[row] == pairs.detection[other]
            for other in chosen
        ):
            chosen.append(row)
    return sorted(chosen)


@given(ticks())
def test_the_flags_give_every_covered_track_its_first_sensor_and_no_other(pairs):
    matrix = covering(pairs, 3, 5)
    flagged = np.zeros_like(matrix)
    is_flagged = flags(pairs)
    flagged[pairs.image[is_flagged], pairs.track[is_flagged]] = True
    first = np.zeros_like(matrix)
    for track in np.flatnonzero(matrix.any(axis=0)):
        first[np.flatnonzero(matrix[:, track])[0], track] = True
    np.testing.assert_array_equal(flagged, first)


@given(ticks())
def test_the_exchange_gives_what_taking_the_cheapest_pair_again_and_again_gives(pairs):
    chosen, rounds, proposals = exchange(pairs.slot, pairs.detection, pairs.likelihood)
    everything = np.arange(len(pairs.slot))
    assert np.flatnonzero(chosen).tolist() == cheapest_first(pairs, everything)
    assert rounds <= proposals <= len(pairs.slot)


@given(ticks())
def test_no_track_is_updated_twice_and_no_detection_is_shared(pairs):
    chosen = ASSOCIATORS['covering_graph']().probabilities(pairs) > 0
    assert len(set(pairs.track[chosen].tolist())) == chosen.sum()
    assert len(set(pairs.detection[chosen].tolist())) == chosen.sum()
    assert flags(pairs)[chosen].all()
    assert np.flatnonzero(chosen).tolist() == cheapest_first(pairs, np.flatnonzero(flags(pairs)))


def test_the_exchange_may_take_more_rounds_than_there_are_tracks():
    rng = np.random.default_rng(15806)
    one, other = np.sort(rng.random(6)), np.sort(rng.random(6))
    slot, detection = map(np.ascontiguousarray, np.nonzero(np.ones((6, 6), bool)))
    likelihood = -np.abs(np.subtract.outer(one, other)).ravel()
    chosen, rounds, proposals = exchange(slot, detection, likelihood)
    assert chosen.sum() == 6
    assert 6 < rounds <= proposals <= 36


def test_of_equals_the_earlier_track_keeps_the_detection():
    slot, detection = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    chosen, rounds, proposals = exchange(slot, detection, np.ones(4))
    assert chosen.tolist() == [True, False, False, True]
    assert (rounds, proposals) == (2, 3)
