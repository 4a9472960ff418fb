import numpy as np

from mctrack_ros.fusion.management.lineage import Lineage
from mctrack_ros.fusion.table import TrackTable

SECOND = 1_000_000_000


def tracks(places, first_id=1, kept_ns=0):
    table = TrackTable.blank(len(places), 2)
    table.track_id[:] = first_id + np.arange(len(places))
    table.mean[:, :2] = places
    table.confirmed[:], table.kept_ns[:] = True, kept_ns
    return table


def test_what_begins_beside_a_track_was_part_of_the_nearest():
    table = tracks([[0.0, 0.0], [1.0, 0.0], [9.0, 9.0]])
    fresh = tracks([[0.8, 0.3], [4.0, 0.0]], first_id=4)
    assert Lineage().origins(fresh.mean, table, 0).tolist() == [2, 0]


def test_a_track_that_is_not_seen_any_more_is_nobodys_origin():
    table, fresh = tracks([[0.0, 0.0]]), tracks([[0.5, 0.0]], first_id=2)
    lineage = Lineage()
    assert lineage.origins(fresh.mean, table, SECOND // 4).tolist() == [1]
    assert lineage.origins(fresh.mean, table, SECOND).tolist() == [0]


def test_who_was_lost_near_by_is_found_again_until_that_is_long_past():
    lineage = Lineage()
    lineage.note_lost(tracks([[3.0, 0.0]]), 0)
    fresh = tracks([[0.5, 0.0]], first_id=2)
    for seconds, expected in ((0.5, 1), (2, 0), (9, 0), (11, 1)):
        now_ns = round(seconds * SECOND)
        table = tracks([[0.0, 0.0]], kept_ns=now_ns)
        assert lineage.origins(fresh.mean, table, now_ns).tolist() == [expected]


def test_without_tracks_nothing_has_a_past():
    nobody = tracks(np.empty((0, 2)))
    lineage = Lineage()
    assert lineage.origins(np.zeros((1, 4)), nobody, 0).tolist() == [0]
    assert lineage.origins(nobody.mean, tracks([[0.0, 0.0]]), 0).tolist() == []


def test_who_was_found_again_is_not_lost_any_more():
    lineage = Lineage()
    lineage.note_lost(tracks([[3.0, 0.0], [2.0, 0.0]], first_id=8), 0)
    fresh, table = tracks([[0.5, 0.0]], first_id=2), tracks([[0.0, 0.0]], kept_ns=2 * SECOND)
    lineage.note_found([8])
    assert lineage.origins(fresh.mean, table, 2 * SECOND).tolist() == [0]
    lineage.note_found([9])
    assert lineage.origins(fresh.mean, table, 2 * SECOND).tolist() == [1]
