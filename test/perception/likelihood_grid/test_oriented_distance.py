"""The oriented distance transform against brute force along every line."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.perception.likelihood_grid.edges import ORIENTATIONS, Edges
from mctrack_ros.perception.likelihood_grid.oriented_distance import (
    FARTHEST_PX,
    MARGIN_PX,
    NONE,
    STEPS,
    TURN,
    OrientedDistance,
)

SIZE = (40, 30)


def edges_of(points):
    pixel = np.array(sorted(points), np.int64)
    direction = np.array([points[each] for each in pixel.tolist()], np.uint8)
    return Edges(pixel, direction)


def offsets(direction):
    """Return distance -> pixels (down, across) that so many steps along a line reach."""
    angle = direction * np.pi / ORIENTATIONS
    found = {0: {(0, 0)}}
    for step in STEPS:
        down, across = round(step * np.sin(angle)), round(step * np.cos(angle))
        for far, places in list(found.items()):
            for sign in (-1, 1):
                moved = {(y + sign * down, x + sign * across) for y, x in places}
                found.setdefault(far + step, set()).update(moved)
    return found


def brute_force(edges):
    width, height = SIZE
    shape = ORIENTATIONS, height + 2 * MARGIN_PX, width + 2 * MARGIN_PX
    distance = np.full(shape, NONE, np.uint8)
    for direction in range(ORIENTATIONS):
        turned = (edges.direction.astype(int) - direction) % ORIENTATIONS
        counts = (turned <= TURN) | (turned >= ORIENTATIONS - TURN)
        for pixel in edges.pixel[counts].tolist():
            row, column = divmod(pixel, width)
            for far, places in offsets(direction).items():
                for down, across in places:
                    place = direction, row + MARGIN_PX + down, column + MARGIN_PX + across
                    distance[place] = min(distance[place], far)
    return distance


SOME = st.dictionaries(
    st.integers(0, SIZE[0] * SIZE[1] - 1), st.integers(0, ORIENTATIONS - 1), max_size=8
)


@settings(max_examples=25, deadline=None)
@given(SOME, SOME)
def test_it_is_the_nearest_edge_on_the_line_whatever_came_before(before, points):
    transform = OrientedDistance(SIZE)
    transform.transform(edges_of(before))
    edges = edges_of(points)
    np.testing.assert_array_equal(transform.transform(edges), brute_force(edges))


def test_along_a_row_it_is_the_distance_to_an_upright_edge():
    edges = edges_of({15 * SIZE[0] + 20: 0})
    row = OrientedDistance(SIZE).transform(edges)[0, 15 + MARGIN_PX, MARGIN_PX:-MARGIN_PX]
    expected = np.abs(np.arange(SIZE[0]) - 20)
    np.testing.assert_array_equal(row, np.where(expected > FARTHEST_PX, NONE, expected))


def test_an_edge_along_the_line_does_not_count():
    edges = edges_of({15 * SIZE[0] + 20: ORIENTATIONS // 2})
    distance = OrientedDistance(SIZE).transform(edges)
    assert (distance[0] == NONE).all()
    assert (distance[ORIENTATIONS // 2] == 0).sum() == 1
