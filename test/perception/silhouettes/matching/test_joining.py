import numpy as np

from mctrack_ros.perception.silhouettes.features import ComparisonConfig, stacked
from mctrack_ros.perception.silhouettes.foreground.components import shapes_of
from mctrack_ros.perception.silhouettes.matching.joining import join_fragments

WEIGHTS = ComparisonConfig(form_weight=1.0, grey_weight=1.0, place_weight=0.0).weights()


def block(top, height, grey=100):
    y, x = np.mgrid[top : top + height, 0:20].reshape(2, -1)
    return shapes_of(x, y, np.full(len(x), grey, np.uint8))


def joined(objects, shapes, match, fragments, joiners=None):
    match = np.array(match, np.bool_)
    everybody = np.ones(len(objects), np.bool_)
    return join_fragments(
        objects,
        shapes,
        match,
        np.ones_like(match),
        everybody if joiners is None else np.array(joiners),
        np.array(fragments),
        WEIGHTS,
    )


def test_the_fragments_of_an_object_come_together_again():
    shapes = stacked(block(0, 20), block(25, 20), block(48, 12))
    found, match, kept = joined(block(0, 60), shapes, [[True, False, False]], [False, True, True])
    assert len(found) == 1
    assert found.area.tolist() == [20 * 52]
    assert found.box.tolist() == [[0, 0, 20, 60]]
    assert match.tolist() == [[True]]
    assert kept.tolist() == [0]


def test_what_would_make_it_look_less_like_the_object_stays_apart():
    shapes = stacked(block(0, 60), block(200, 60, 250))
    found, _, kept = joined(block(0, 60), shapes, [[True, False]], [False, True])
    assert kept.tolist() == [0, 1]
    assert found.area.tolist() == [1200, 1200]


def test_securely_matched_silhouettes_and_those_out_of_reach_are_not_taken():
    shapes = stacked(block(0, 30), block(30, 30))
    _, _, kept = joined(block(0, 60), shapes, [[True, False]], [False, False])
    assert kept.tolist() == [0, 1]


def test_who_was_matched_to_a_fragment_that_was_taken_has_lost_it():
    objects = stacked(block(0, 60), block(30, 30))
    shapes = stacked(block(0, 30), block(30, 30))
    found, match, _ = joined(
        objects, shapes, [[True, False], [False, True]], [False, True], [True, True]
    )
    assert match.tolist() == [[True], [False]]
    assert found.area.tolist() == [1200]


def test_objects_without_a_silhouette_take_none():
    _, match, kept = joined(block(0, 60), block(0, 30), [[False]], [True])
    assert not match.any()
    assert kept.tolist() == [0]
