import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mctrack_ros.perception.events.groups import Change, GroupConfig, Groups

PERIOD_NS = 40_000_000


class Film:
    """Feed images; each is given as the sets of tracks that touch, others are alone."""

    def __init__(self, part_s=0.4):
        self.groups, self.now_ns = Groups(GroupConfig(part_s=part_s)), 10**18

    def show(self, *parts, unseen=(), quiet=()):
        self.now_ns += PERIOD_NS
        ids = sorted({*unseen, *(one for part in parts for one in part)})
        part_of = {one: number for number, part in enumerate(parts) for one in part}
        place = np.array([part_of.get(one, -1) for one in ids])
        return self.groups.step(np.array(ids), place, self.now_ns, np.isin(ids, quiet))

    def hold(self, count, *parts, unseen=()):
        return [change for _ in range(count) for change in self.show(*parts, unseen=unseen)]


@pytest.fixture
def film():
    return Film()


def test_two_that_touch_merge_once_and_part_after_some_time(film):
    film.show({1}, {2})
    assert film.show({1, 2}) == [Change(True, (2,), (1,))]
    assert film.hold(20, {1, 2}) == []
    assert film.hold(9, {1}, {2}) == []
    assert film.show({1}, {2}) == [Change(False, (2,), (1,))]
    assert film.hold(20, {1}, {2}) == []


def test_a_moment_apart_is_no_split(film):
    film.hold(5, {1, 2})
    for _ in range(5):
        assert film.hold(8, {1}, {2}) + film.show({1, 2}) == []


def test_the_smaller_part_joins_and_leaves(film):
    film.hold(5, {1, 2, 3}, {4, 5})
    assert film.show({1, 2, 3, 4, 5}) == [Change(True, (4, 5), (1, 2, 3))]
    assert film.hold(10, {1}, {2, 3, 4, 5}) == [Change(False, (1,), (2, 3, 4, 5))]


def test_one_who_was_there_unnoticed_joins_without_a_word_and_leaves_as_a_member(film):
    film.hold(5, {1, 2}, {4})
    assert film.show({1, 2, 3}, {4}, quiet=[3]) == []
    assert film.hold(10, {1, 2}, {3}, {4}) == [Change(False, (3,), (1, 2))]


def test_who_is_known_already_merges_aloud(film):
    film.hold(5, {1}, {3})
    assert film.show({1, 3}, quiet=[1, 3]) == [Change(True, (3,), (1,))]


def test_one_who_touches_a_member_is_of_the_group(film):
    film.hold(5, {1, 2}, {3})
    assert film.show({1}, {2, 3}) == [Change(True, (3,), (1, 2))]
    assert film.hold(10, {1}, {2, 3}) == [Change(False, (1,), (2, 3))]


def test_who_is_not_seen_stays_in_the_group(film):
    film.hold(5, {1, 2})
    assert film.hold(30, {1}, unseen=[2]) == []
    assert film.hold(10, {1}, {2}) == [Change(False, (2,), (1,))]


def test_who_is_lost_leaves_without_an_event(film):
    film.hold(5, {1, 2, 3})
    assert film.hold(20, {1, 2}) == []
    assert film.hold(10, {1}, {2}) == [Change(False, (2,), (1,))]


def test_a_track_that_begins_in_a_group_joins_it(film):
    film.hold(5, {1, 2})
    assert film.show({1, 2, 3}) == [Change(True, (3,), (1, 2))]


@hypothesis_settings(deadline=None, max_examples=50)
@given(st.lists(st.lists(st.integers(0, 3), min_size=5, max_size=5), min_size=1, max_size=30))
def test_merges_and_splits_add_up_to_the_groups(images):
    film, count = Film(part_s=0.08), 5
    for places in images:
        parts = [{one for one in range(5) if places[one] == place} for place in range(4)]
        for change in film.show(*[part for part in parts if part]):
            assert change.part
            assert change.rest
            assert not set(change.part) & set(change.rest)
            count += -1 if change.merged else 1
        assert count == len(np.unique(film.groups._group))


def test_members_of_groups_are_named():
    groups = Groups(GroupConfig())
    groups.step(np.array([1, 2, 5, 8]), np.array([0, 0, 1, 0]), 1)
    assert groups.members() == [(1, 2, 8)]
    groups.restart()
    assert groups.members() == []


def test_those_who_exchange_names_are_grouped_as_they_were(film):
    film.hold(20, {1, 2}, {3})
    film.groups.rename({1: 3, 3: 1})
    assert film.groups.members() == [(2, 3)]
    assert film.hold(20, {2, 3}, {1}) == []


def test_one_who_gets_back_his_old_name_stays_in_his_group(film):
    film.hold(20, {1, 7}, {3})
    film.groups.rename({7: 2})
    assert film.hold(20, {1, 2}, {3}) == []


def test_a_name_that_another_has_is_not_given_away(film):
    film.hold(20, {1, 2}, {3})
    film.groups.rename({3: 2})
    assert film.groups.members() == [(1, 2)]
