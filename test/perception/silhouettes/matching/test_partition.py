import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mctrack_ros.perception.silhouettes.features import ComparisonConfig, stacked
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.matching.partition import (
    DivisionConfig,
    direction,
    partition_merged,
    pieces_of,
)

WEIGHTS = ComparisonConfig(form_weight=1.0, grey_weight=1.0, place_weight=0.0).weights()
NOBODY = np.zeros((0, 2))
AREAS = st.lists(st.floats(1.0, 500.0), min_size=2, max_size=5)


@given(arrays(np.float64, st.integers(5, 200), elements=st.floats(-300, 300)), AREAS)
def test_pieces_hold_every_pixel_once_in_order_and_in_proportion(along, areas):
    piece = pieces_of(along, np.array(areas))
    assert piece.shape == along.shape
    assert set(piece.tolist()) <= set(range(len(areas)))
    assert (np.diff(piece[np.argsort(along, kind='stable')]) >= 0).all()
    if len(np.unique(along)) == len(along):
        share = np.cumsum(areas)[:-1] / np.sum(areas)
        held = np.cumsum(np.bincount(piece, minlength=len(areas)))[:-1]
        assert np.allclose(held, share * len(along), atol=1.0 + 1e-6)


@pytest.mark.parametrize('slope', [-0.7, 0.0, 0.4])
def test_regression_is_that_of_least_squares(slope):
    rng = np.random.default_rng(2)
    x = rng.uniform(0, 100, 400)
    y = 3 + slope * x + rng.normal(0, 5, 400)
    fitted = np.polyfit(x, y, 1)[0]
    line = direction(x, y, NOBODY, 'regression')
    assert line[1] / line[0] == pytest.approx(fitted)


@given(st.floats(-1.5, 1.5))
def test_principal_axis_is_that_of_largest_spread(angle):
    rng = np.random.default_rng(3)
    long, short = rng.normal(0, 30, 500), rng.normal(0, 5, 500)
    x = long * np.cos(angle) - short * np.sin(angle)
    y = long * np.sin(angle) + short * np.cos(angle)
    axis = np.linalg.eigh(np.cov(x, y))[1][:, -1]
    assert abs(direction(x, y, NOBODY, 'principal') @ axis) == pytest.approx(1.0)


def drawn(boxes):
    """Return the silhouettes of rectangles (left, top, width, height, grey) in one image."""
    grey, mask = np.zeros((120, 160), np.uint8), np.zeros((120, 160), np.uint8)
    for left, top, width, height, value in boxes:
        grey[top : top + height, left : left + width] = value
        mask[top : top + height, left : left + width] = 255
    return find_silhouettes(mask, grey, ComponentConfig(opening_px=1, closing_px=1))


def divided(before, after, line='objects'):
    """Divide what is seen after among the objects before, who all want silhouette 0."""
    objects = stacked(*(drawn([box]).shapes for box in before))
    silhouettes = drawn(after)
    match = np.zeros((len(objects), len(silhouettes.shapes)), np.bool_)
    match[:, 0] = True
    established = np.ones(len(objects), np.bool_)
    config = DivisionConfig(line=line)
    shapes = silhouettes.shapes
    return partition_merged(
        objects,
        silhouettes,
        shapes,
        np.ones(len(shapes), np.bool_),
        match,
        established,
        config,
        WEIGHTS,
    )


@pytest.mark.parametrize('line', ['objects', 'regression'])
def test_two_who_touch_side_by_side_are_told_apart(line):
    people = [(40, 30, 20, 60, 50), (60, 32, 20, 60, 200)]
    shapes, match, origin = divided(people, people, line)
    assert len(shapes) == 2
    assert origin.tolist() == [0, 0]
    assert (match.sum(axis=0) == 1).all()
    assert (match.sum(axis=1) == 1).all()
    for row, person in enumerate(people):
        box = shapes.box[match[row].argmax()]
        assert np.allclose(box, person[:4], atol=3)


@pytest.mark.parametrize('line', ['objects', 'principal'])
def test_those_one_above_the_other_are_told_apart(line):
    people = [(40, 5, 16, 50, 50), (42, 55, 16, 60, 200)]
    shapes, match, _ = divided(people, people, line)
    for row, person in enumerate(people):
        assert np.allclose(shapes.box[match[row].argmax()], person[:4], atol=3)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 255))
def test_a_partition_conserves_pixels_and_their_greys(first, second, grey):
    people = [(20, 30, first, 40, grey), (20 + first, 30, second, 40, 255 - grey)]
    whole = drawn(people).shapes
    shapes, match, origin = divided(people, people)
    assert np.allclose(shapes.vector[origin == 0][:, :1].sum(), whole.area)
    assert np.allclose(shapes.vector[:, 3:19].sum(axis=0), whole.vector[0, 3:19])
    assert match.any(axis=1).all()


def test_a_partition_that_helps_nobody_is_not_made():
    person = (40, 30, 20, 60, 50)
    shapes, match, _ = divided([person, person], [person])
    assert len(shapes) == 1
    assert match[:, 0].all()
