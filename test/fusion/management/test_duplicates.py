import numpy as np
import pytest

from mctrack_ros.fusion.management.duplicates import DuplicateWatch, close_pairs
from mctrack_ros.fusion.neighbours import near_pairs
from mctrack_ros.fusion.table import TrackTable

SECOND_NS = 1_000_000_000
PERIOD_S = 0.04
LIMIT_M, LIMIT_S = 1.0, 1.0


def two_tracks(distance=0.0, confirmed=(True, True), reported=False):
    """Return tracks 7 and 8, of which two cameras see one each, or one sees both."""
    table = TrackTable.blank(2, 2)
    table.track_id, table.confirmed = [7, 8], confirmed
    table.mean[:, 0] = [0.0, distance]
    table.cameras = [0b01, 0b01 if reported else 0b10]
    table.seen_by_ns[0, 0] = table.seen_by_ns[1, 0 if reported else 1] = SECOND_NS
    return table


def pairs_of(table):
    return close_pairs(table, *near_pairs(table.mean, 2 * LIMIT_M), LIMIT_M, PERIOD_S)


class Watched:
    """Ticks of two tracks, and what a watch makes of them."""

    def __init__(self):
        self.watch, self.found = DuplicateWatch(LIMIT_S), []

    def ticks(self, count, over=(False, False), **how):
        """Add ticks until the two are one; return how many it took."""
        table = two_tracks(**how)
        for index in range(count):
            self.found = self.watch.find(table, pairs_of(table), np.array(over))
            if self.found:
                return index + 1
        return count


@pytest.fixture
def watched():
    return Watched()


def test_only_pairs_nearer_than_the_limit_are_close():
    assert len(pairs_of(two_tracks(0.99)).one) == 1
    assert len(pairs_of(two_tracks(1.01)).one) == 0


def test_an_image_of_both_tells_them_apart_unless_it_is_an_old_one():
    table = two_tracks(0.3, reported=True)
    assert pairs_of(table).reported.tolist() == [True]
    table.seen_by_ns[1, 0] -= SECOND_NS
    assert pairs_of(table).reported.tolist() == [False]
    assert pairs_of(two_tracks(0.3)).reported.tolist() == [False]


def test_who_is_in_a_group_is_said():
    table = two_tracks(0.3)
    assert pairs_of(table).grouped.tolist() == [False]
    table.group[1] = 3
    assert pairs_of(table).grouped.tolist() == [True]


@pytest.mark.parametrize(('distance', 'seconds'), [(0.0, 1.0), (0.5, 2.0), (0.75, 4.0)])
def test_the_farther_apart_the_longer_it_takes(watched, distance, seconds):
    taken = watched.ticks(200, distance=distance)
    assert taken - 1 == pytest.approx(seconds / PERIOD_S, abs=1)
    assert watched.found == [(0, 1)]


def test_who_is_confirmed_is_kept_else_the_first(watched):
    watched.ticks(200, confirmed=(False, True))
    assert watched.found == [(1, 0)]


def test_an_image_of_both_takes_away_five_ticks(watched):
    watched.ticks(21)
    watched.ticks(2, reported=True)
    assert watched.ticks(200) == pytest.approx(25 - 10, abs=1)


def test_with_nothing_left_they_begin_anew(watched):
    watched.ticks(21)
    watched.ticks(10, reported=True)
    assert watched.ticks(200) == pytest.approx(26, abs=1)


def test_two_that_a_camera_shows_are_never_found_while_it_does(watched):
    watched.ticks(25)
    watched.ticks(1, reported=True, over=(True, False))
    assert watched.found == []


def test_two_that_part_begin_anew(watched):
    watched.ticks(21)
    watched.ticks(1, distance=1.5)
    assert watched.ticks(200) == pytest.approx(26, abs=1)


def test_half_the_time_is_enough_where_one_would_end(watched):
    watched.ticks(11)
    watched.ticks(1, over=(True, False))
    assert watched.found == []
    watched.ticks(2)
    watched.ticks(1, over=(True, False))
    assert watched.found == [(0, 1)]


def test_of_three_in_one_place_two_become_one_at_a_time():
    table = two_tracks()
    table.append(table.select(np.array([1])))
    table.track_id[2] = 9
    watch, over = DuplicateWatch(LIMIT_S), np.zeros(3, bool)
    found = [watch.find(table, pairs_of(table), over) for _ in range(40)]
    assert next(pairs for pairs in found if pairs) == [(0, 1)]


def test_who_is_one_with_somebody_seen_has_not_gone():
    for is_somebody, missed in ((True, 0.5), (False, 9.0)):
        table = two_tracks()
        table.missed, table.confirmed = [9.0, 0.5], [True, is_somebody]
        table.shown_by = [1, 2]
        table.absorb(0, 1)
        assert table.missed[0] == missed
        assert table.shown_by[0] == 3


def test_of_two_who_are_one_all_that_is_known_is_kept():
    table = two_tracks()
    table.seen_by_ns[:] = [[5, 9], [7, 3]]
    table.seen_ns, table.kept_ns, table.evidence = [5, 8], [9, 7], [1.0, 2.0]
    table.covariance[:] = np.eye(4) * np.array([2.0, 1.0])[:, None, None]
    table.mean[:] = np.arange(8).reshape(2, 4)
    table.extent[:] = [[0.5, np.nan], [0.7, 1.8]]
    table.template[1] = 0.25
    sure, unsure = table.select(np.array([0, 1])), table.select(np.array([0, 1]))
    unsure.covariance[1] *= 3.0
    unsure.template[0] = 0.5
    for each in (sure, unsure):
        each.absorb(0, 1)
        assert each.seen_by_ns[0].tolist() == [7, 9]
        assert (each.seen_ns[0], each.kept_ns[0], each.evidence[0]) == (8, 9, 2.0)
        assert (each.cameras[0], each.previous_id[0]) == (0b11, 8)
        np.testing.assert_allclose(each.extent[0], [0.5, 1.8])
    np.testing.assert_array_equal(sure.mean[0], table.mean[1])
    np.testing.assert_array_equal(sure.covariance[0], table.covariance[1])
    np.testing.assert_array_equal(unsure.mean[0], table.mean[0])
    np.testing.assert_array_equal(unsure.covariance[0], table.covariance[0])
    assert (sure.template[0] == 0.25).all()
    assert (unsure.template[0] == 0.5).all()
