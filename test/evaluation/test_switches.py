import numpy as np
import pytest

from mctrack_ros.evaluation import Trajectories, evaluate_ground, identity_switches


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
