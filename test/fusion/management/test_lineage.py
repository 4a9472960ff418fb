import numpy as np

from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.management.lineage import origins
from mctrack_ros.fusion.reid.appearance import AppearanceModel
from mctrack_ros.fusion.reid.lost_targets import LostTargets
from mctrack_ros.fusion.table import TrackTable

SECOND = 1_000_000_000
NOBODY = np.empty((0, 2)), np.empty(0)


def tracks(places, first_id=1, kept_ns=0):
    table = TrackTable.blank(len(places), 2)
    table.track_id[:] = first_id + np.arange(len(places))
    table.mean[:, :2] = places
    table.confirmed[:], table.kept_ns[:] = True, kept_ns
    return table


def test_what_begins_beside_a_track_was_part_of_the_nearest():
    table = tracks([[0.0, 0.0], [1.0, 0.0], [9.0, 9.0]])
    fresh = tracks([[0.8, 0.3], [4.0, 0.0]], first_id=4)
    assert origins(fresh.mean, table, NOBODY, 0).tolist() == [2, 0]


def test_a_track_that_is_not_seen_any_more_is_nobodys_origin():
    table, fresh = tracks([[0.0, 0.0]]), tracks([[0.5, 0.0]], first_id=2)
    assert origins(fresh.mean, table, NOBODY, SECOND // 4).tolist() == [1]
    assert origins(fresh.mean, table, NOBODY, SECOND).tolist() == [0]


def test_who_was_lost_near_by_may_be_found_again():
    fresh, table = tracks([[0.5, 0.0]], first_id=2), tracks([[0.0, 0.0]])
    for seconds, expected in ((0.5, 1), (2, 0), (9, 0)):
        lost = np.array([[3.0, 0.0]]), np.array([seconds])
        assert origins(fresh.mean, table, lost, 0).tolist() == [expected]


def test_without_tracks_nothing_has_a_past():
    nobody = tracks(np.empty((0, 2)))
    assert origins(np.zeros((1, 4)), nobody, NOBODY, 0).tolist() == [0]
    assert origins(nobody.mean, tracks([[0.0, 0.0]]), NOBODY, 0).tolist() == []


def test_who_was_lost_lately_is_known_until_he_is_found_again_or_that_is_long_past():
    lost = LostTargets(JointConfig(), AppearanceModel())
    lost.add(tracks([[3.0, 0.0], [2.0, 0.0]], first_id=8), SECOND)
    place, ago_s = lost.lately(3 * SECOND, 10.0)
    assert place.tolist() == [[3, 0], [2, 0]]
    assert ago_s.tolist() == [2, 2]
    lost.remove(8)
    assert lost.lately(3 * SECOND, 10.0)[0].tolist() == [[2, 0]]
    assert lost.lately(12 * SECOND, 10.0)[0].tolist() == []
