import numpy as np
import pytest

from mctrack_ros.perception.silhouettes.features import PLACE, SIZE, Shapes
from mctrack_ros.perception.silhouettes.objects import ObjectConfig, ObjectList, at_edge

PERIOD_S = 0.25
ONE = np.ones((1, 1), np.bool_)


def body(x, y=100.0, width=20.0, height=60.0):
    """Return the shape of one upright block about a place."""
    vector = np.zeros((1, SIZE))
    vector[0, :3] = width * height, width, height
    vector[0, PLACE] = x, y
    return Shapes(vector, np.array([[x - width / 2, y - height / 2, width, height]]))


def nothing():
    return body(0.0).select(np.zeros(0, np.int64))


class Film:
    """Shows an object list one silhouette, or none, in each image."""

    def __init__(self, **config):
        self.objects, self.index = ObjectList(ObjectConfig(**config)), 0
        self.objects.start(body(100.0), 0)

    def show(self, x=None):
        self.index += 1
        stamp_ns = round(self.index * PERIOD_S * 1e9)
        shapes = nothing() if x is None else body(x)
        self.objects.predict(PERIOD_S)
        match, covers = np.ones((1, len(shapes)), np.bool_), np.zeros(len(shapes), np.bool_)
        lost = self.objects.update(shapes, match, covers, stamp_ns, PERIOD_S)
        self.objects.alone_s[self.objects.matched] += PERIOD_S
        return bool(lost[0])


@pytest.fixture
def walker():
    """Return the film of somebody who has walked 4 px an image for 3 s."""
    film = Film()
    for step in range(12):
        film.show(104.0 + 4 * step)
    return film


def test_whoever_comes_some_way_is_established():
    film, established = Film(), []
    for step in range(8):
        film.show(104.0 + 4 * step)
        established.append(bool(film.objects.established[0]))
    assert established == [False] * 4 + [True] * 4


def test_what_does_not_move_is_not():
    film = Film()
    for _ in range(40):
        film.show(102.0)
    assert not film.objects.established[0]


def test_as_printed_two_images_are_enough():
    film = Film(establish_s=0.2, move_px=0.0)
    film.show(100.0)
    assert film.objects.established[0]


def test_an_object_is_expected_where_it_was_going(walker):
    for _ in range(3):
        walker.show()
    walker.objects.predict(PERIOD_S)
    assert walker.objects.shapes.centroid[0, 0] == pytest.approx(148.0 + 16.0, abs=1.5)


def test_a_known_object_stays_without_a_match_for_a_while(walker):
    lost = [walker.show() for _ in range(20)]
    assert lost.index(True) * PERIOD_S == ObjectConfig().hold_s


def test_who_is_hardly_known_stays_for_as_long_as_he_was_seen():
    film = Film()
    for step in range(6):
        film.show(104.0 + 4 * step)
    lost = [film.show() for _ in range(10)]
    assert lost.index(True) * PERIOD_S == 6 * PERIOD_S


@pytest.mark.parametrize('covers', [True, False])
def test_who_is_expected_within_a_large_silhouette_is_awaited_for_longer(walker, covers):
    objects = walker.objects
    objects.start(body(130.0, width=200.0), 3_000_000_000)
    match = np.array([[False], [True]])
    for step in range(20):
        stamp_ns = round((3.0 + PERIOD_S * (step + 1)) * 1e9)
        shapes = body(130.0, width=200.0)
        lost = objects.update(shapes, match, np.array([covers]), stamp_ns, PERIOD_S)
    assert lost.tolist() == [not covers, False]


def test_a_transient_object_does_not():
    assert Film().show()


def test_features_follow_slowly_and_the_box_at_once(walker):
    walker.objects.update(
        body(152.0, width=40.0), ONE, np.zeros(1, np.bool_), 3_250_000_000, PERIOD_S
    )
    assert 20.0 < walker.objects.vector[0, 1] < 30.0
    assert walker.objects.box[0, 2] == 40.0


def test_ids_are_never_used_again():
    objects = ObjectList(ObjectConfig())
    objects.start(body(100.0), 0)
    objects.clear()
    objects.start(body(100.0), 0)
    assert objects.local_id.tolist() == [2]


def test_boxes_near_the_edge_are_told():
    box = np.array([[0.0, 50, 10, 10], [30, 30, 10, 10], [85, 30, 10, 10]])
    assert at_edge(box, (80, 100), 6.0).tolist() == [True, False, True]
