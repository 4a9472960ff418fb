import numpy as np
import pytest

from mctrack_ros.evaluation import (
    Trajectories,
    evaluate_ground,
    identity_switches,
    while_isolated,
)


def exchanged():
    """Return two who stand still, whose tracks are exchanged in frame 5, one unseen before."""
    frame, who = np.repeat(np.arange(10), 2), np.tile([7, 8], 10)
    position = np.column_stack([np.where(who == 7, 0.0, 5.0), np.zeros(20)])
    truth = Trajectories(frame, who, position)
    ids = np.where((who == 7) ^ (frame >= 5), 20, 30)
    seen = ~((who == 7) & (frame == 4))
    return truth, Trajectories(frame[seen], ids[seen], position[seen])


def test_each_switch_says_who_was_taken_for_whom_where_and_when():
    switches = identity_switches(*exchanged(), 1.0)
    assert len(switches) == 2
    assert switches.frame.tolist() == [5, 5]
    assert switches.truth_id.tolist() == [7, 8]
    assert switches.last_frame.tolist() == [3, 4]
    assert switches.old_id.tolist() == [20, 30]
    assert switches.new_id.tolist() == [30, 20]
    assert switches.position.tolist() == [[0, 0], [5, 0]]


def test_without_switches_the_list_is_empty():
    truth, _ = exchanged()
    assert len(identity_switches(truth, truth, 1.0)) == 0
    empty = Trajectories([], [])
    assert len(identity_switches(empty, empty, 1.0)) == 0


@pytest.mark.parametrize('seed', range(4))
def test_there_are_as_many_as_are_scored(seed):
    rng = np.random.default_rng(seed)
    frame, who = np.repeat(np.arange(30), 4), np.tile(np.arange(4), 30)
    place = np.column_stack([who * 0.6, np.zeros(120)])
    tracks = Trajectories(frame, who + 10, place + rng.normal(0, 0.7, (120, 2)))
    truth = Trajectories(frame, who, place)
    switches = identity_switches(truth, tracks, 1.0)
    assert len(switches) == evaluate_ground(truth, tracks, 1.0).switches > 0
    assert (switches.old_id != switches.new_id).all()
    assert (switches.last_frame < switches.frame).all()


def test_who_was_alone_is_told_from_who_was_not_for_a_moment():
    frame, who = np.repeat(np.arange(20), 3), np.tile([1, 2, 3], 20)
    position = np.column_stack([10.0 * who, np.zeros(60)])
    position[(who == 2) & (frame == 7)] = [11.0, 0.0]  # beside the first for one image
    truth = Trajectories(frame, who, position)
    ids = np.where(frame >= 10, who + 20, who + 10)
    switches = identity_switches(truth, Trajectories(frame, ids, position), 1.0)
    assert switches.truth_id.tolist() == [1, 2, 3]
    assert while_isolated(switches, truth, 3.0, 2).tolist() == [False, False, True]
    assert while_isolated(switches, truth, 3.0, 1).tolist() == [True, True, True]
    assert while_isolated(switches, truth, 0.5, 9).all()
