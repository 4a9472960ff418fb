import numpy as np

from mctrack_ros.perception.events.view_events import StableEvents

PERIOD_NS = 40_000_000


class Film:
    def __init__(self):
        self.steadiness, self.now_ns = StableEvents(0.4), 10**18

    def show(self, *people):
        """Advance an image; people are (key, whether they are tracked alone)."""
        self.now_ns += PERIOD_NS
        key, alone = np.array(people, np.int64).reshape(-1, 2).T
        return key[self.steadiness.step(key, alone > 0, self.now_ns)].tolist()

    def hold(self, count, *people):
        return [key for _ in range(count) for key in self.show(*people)]


ALONE, GROUPED = (7, 1), (7, 0)


def test_one_tracked_alone_for_a_while_is_stable_once():
    film = Film()
    assert film.hold(10, ALONE) == []
    assert film.hold(20, ALONE) == [7]


def test_after_a_group_one_is_stable_again():
    film = Film()
    film.hold(20, ALONE)
    assert film.hold(20, GROUPED) == []
    assert film.hold(20, ALONE) == [7]


def test_the_time_begins_anew_whenever_one_is_not_alone():
    film = Film()
    film = Film()
    for _ in range(5):
        assert film.hold(8, ALONE) + film.show(GROUPED) == []
