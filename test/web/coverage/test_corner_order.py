import pytest

from mctrack_ros.web.coverage.corner_order import place_in_order

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]
L_SHAPE = [(0, 0), (10, 0), (10, 5), (5, 5), (5, 10), (0, 10)]


@pytest.mark.parametrize(
    'polygon', [SQUARE, L_SHAPE, SQUARE[::-1], [(x, y / 20) for x, y in SQUARE]]
)
def test_clicked_around_in_order_corners_stay_in_order(polygon):
    corners = []
    for corner in polygon:
        corners.insert(place_in_order(corners, corner), corner)
    assert corners == polygon


@pytest.mark.parametrize(
    ('new', 'index'),
    [((10.5, 5), 2), ((5, -0.5), 1), ((-0.5, 5), 4), ((5, 9.2), 3), ((-4, 5), 4)],
)
def test_a_corner_near_an_edge_divides_it(new, index):
    assert place_in_order(SQUARE, new) == index


def test_a_corner_that_would_cross_the_polygon_at_the_end_goes_where_it_is_nearest():
    assert place_in_order(SQUARE, (14, 5)) == 2
    assert place_in_order(SQUARE, (5, -4)) == 1
