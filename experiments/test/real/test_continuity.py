import numpy as np

from mctrack_experiments.real.continuity import isolated_breaks
from mctrack_ros.evaluation import Trajectories


def straight(track, first, last, y=0.0):
    """Return the rows of somebody who walks 0.1 m a frame along x."""
    frame = np.arange(first, last)
    return (
        frame,
        np.full(len(frame), track),
        np.column_stack([frame * 0.1, np.full(len(frame), y)]),
    )


def together(*paths):
    return Trajectories(*(np.concatenate(part) for part in zip(*paths)))


def test_a_track_that_goes_on_under_another_id_alone_is_a_break():
    assert isolated_breaks(together(straight(1, 0, 10), straight(2, 12, 20)), 5) == 1


def test_what_happens_beside_others_late_or_far_away_is_none():
    beside = straight(3, 0, 20, y=1.5)
    assert isolated_breaks(together(straight(1, 0, 10), straight(2, 12, 20), beside), 5) == 0
    assert isolated_breaks(together(straight(1, 0, 10), straight(2, 17, 30)), 5) == 0
    assert isolated_breaks(together(straight(1, 0, 10), straight(2, 12, 20, y=4.0)), 5) == 0


def test_nobody_and_a_whole_track_are_no_breaks():
    assert isolated_breaks(together(straight(1, 0, 30)), 5) == 0
    assert isolated_breaks(Trajectories([], [], np.empty((0, 2))), 5) == 0
