import numpy as np

from mctrack_ros.perception.events.stable_events import StableEvents
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

PERIOD_NS = 40_000_000


class Film:
    def __init__(self):
        self.steadiness, self.now_ns = StableEvents(0.4), 10**18

    def show(self, *people):
        """Advance an image; people are (key, local id, size of the group, part)."""
        self.now_ns += PERIOD_NS
        key, local_id, size, part = np.array(people, np.int64).reshape(-1, 4).T
        count = len(key)
        in_view = PersonsInView(
            key, local_id, key, np.zeros((count, 2)), np.zeros((count, 4)), np.zeros(count, bool)
        )
        return key[self.steadiness.step(in_view, size, part, self.now_ns)].tolist()

    def hold(self, count, *people):
        return [key for _ in range(count) for key in self.show(*people)]


ALONE, GROUPED, HIDDEN, UNSEEN = (7, 1, 1, 0), (7, 1, 2, 0), (7, 0, 1, 0), (7, 1, 1, -1)


def test_one_tracked_alone_for_a_while_is_stable_once():
    film = Film()
    assert film.hold(10, ALONE) == []
    assert film.hold(20, ALONE) == [7]


def test_after_a_group_one_is_stable_again():
    film = Film()
    film.hold(20, ALONE)
    assert film.hold(20, GROUPED) == []
    assert film.hold(20, ALONE) == [7]


def test_who_has_no_track_of_his_own_or_is_not_seen_is_not_stable():
    for doubtful in (HIDDEN, UNSEEN):
        assert Film().hold(20, doubtful) == []


def test_the_time_begins_anew_whenever_one_is_not_alone():
    film = Film()
    film = Film()
    for _ in range(5):
        assert film.hold(8, ALONE) + film.show(GROUPED) == []
