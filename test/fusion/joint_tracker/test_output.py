"""What is published of tracks is what is known of them."""

import numpy as np
from scipy.special import expit

from mctrack_ros.fusion.joint_tracker.output import feedback_of, status_of, tracks_of
from mctrack_ros.fusion.management.event_log import EventLog
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import MEMBERS, EventCode, TrackStatus

NOW_NS = 90_000_000_000
SECOND_NS = 1_000_000_000


def tracks(ids, seed=0):
    """Return tracks of which everything that is published differs."""
    rng, count = np.random.default_rng(seed), len(ids)
    table = TrackTable.blank(count, 3)
    table.track_id[:] = ids
    table.mean[:] = rng.normal(0, 3, (count, 4))
    root = rng.normal(0, 1, (count, 4, 4))
    table.covariance[:] = root @ root.swapaxes(1, 2)
    table.extent[:] = rng.uniform(0.5, 2, (count, 2))
    table.evidence[:] = rng.uniform(-2, 6, count)
    table.first_ns[:] = NOW_NS - rng.integers(1, 60, count) * SECOND_NS
    table.class_id[:], table.kit[:] = rng.integers(0, 4, (2, count))
    return table


def test_tracks_are_told_by_id_with_those_that_ended_among_them():
    table, ended = tracks([2, 3, 5, 8, 13]), tracks([4, 1], seed=1)
    is_published = np.array([True, True, False, True, True])
    table.confirmed[:] = [False, True, True, True, True]
    table.cameras[:] = [4, 5, 1, 0, 0]
    table.group[:] = [0, 0, 0, 3, 0]
    told = tracks_of(table, is_published, ended, NOW_NS)
    assert told.track_id.tolist() == [1, 2, 3, 4, 8, 13]
    assert told.status.tolist() == [
        TrackStatus.DELETED,
        TrackStatus.TENTATIVE,
        TrackStatus.CONFIRMED,
        TrackStatus.DELETED,
        TrackStatus.GROUPED,
        TrackStatus.COASTING,
    ]
    living = table.select(is_published)
    states = zip(living.confirmed.tolist(), living.cameras.tolist(), living.group.tolist())
    assert [status_of(*each) for each in states] == told.status[[1, 2, 4, 5]].tolist()
    both = table.extended(ended).select(np.array([6, 0, 1, 5, 3, 4]))
    np.testing.assert_allclose(told.position[:, :2], both.mean[:, :2], rtol=1e-6)
    np.testing.assert_array_equal(told.position[:, 2], 0.0)
    np.testing.assert_allclose(told.velocity[:, :2], both.mean[:, 2:], rtol=1e-6)
    np.testing.assert_allclose(told.covariance, both.covariance, rtol=1e-6)
    np.testing.assert_allclose(told.age, (NOW_NS - both.first_ns) / 1e9)
    np.testing.assert_allclose(told.score, expit(both.evidence), rtol=1e-6)
    for name in ('extent', 'group', 'cameras', 'class_id', 'kit'):
        np.testing.assert_array_equal(getattr(told, name), getattr(both, name))
    np.testing.assert_array_equal(told.member_count, 1)


def test_cameras_are_told_where_targets_are_and_what_they_were_called():
    table = tracks([1, 2])
    table.previous_id[1] = 7
    told = feedback_of(table, NOW_NS)
    assert told.corrections() == {7: 2}
    np.testing.assert_allclose(told.position[:, :2], table.mean[:, :2], rtol=1e-6)
    np.testing.assert_allclose(told.velocity[:, :2], table.mean[:, 2:], rtol=1e-6)
    np.testing.assert_allclose(told.covariance, table.covariance, rtol=1e-6)


def test_events_are_sorted_and_name_the_others_of_a_group():
    table, log = tracks([3, 9]), EventLog()
    crowd = np.arange(1, MEMBERS + 5, dtype=np.uint32)
    log.add(EventCode.MERGE, table, 1, others=crowd)
    log.add(EventCode.CORRECTION, table, 0, old_id=5, probability=0.75)
    log.add_all(EventCode.NEW, table, np.array([True, True]))
    events = log.events(NOW_NS)
    order = np.lexsort((events.track_id, events.event))
    assert order.tolist() == list(range(4))
    told = {
        (int(code), int(one)): row
        for row, (code, one) in enumerate(zip(events.event, events.track_id))
    }
    merge, correction = told[EventCode.MERGE, 9], told[EventCode.CORRECTION, 3]
    assert events.others[merge].tolist() == [one for one in crowd.tolist() if one != 9][:MEMBERS]
    assert (events.old_id[correction], events.new_id[correction]) == (5, 3)
    assert events.probability[correction] == 0.75
    for track, code in ((0, EventCode.NEW), (1, EventCode.NEW), (1, EventCode.MERGE)):
        row = told[code, int(table.track_id[track])]
        np.testing.assert_allclose(
            events.probability[row], expit(table.evidence[track]), rtol=1e-6
        )
        np.testing.assert_allclose(events.position[row, :2], table.mean[track, :2], rtol=1e-6)
        assert events.new_id[row] == 0
