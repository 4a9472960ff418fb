import numpy as np
import pytest

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.interfaces import Tracks, TrackStatus


def test_ticks_become_frames_of_the_tracks_reported():
    period = 40_000_000
    first = Tracks.build(
        1_000_000_000 + period // 2,
        position=[[1, 2, 0], [3, 4, 0], [5, 6, 0]],
        track_id=[7, 8, 9],
        status=[TrackStatus.CONFIRMED, TrackStatus.TENTATIVE, TrackStatus.DELETED],
    )
    second = Tracks.build(
        first.stamp_ns + period + 1000,
        position=[[1, 2.5, 0], [3, 4.5, 0]],
        track_id=[7, 8],
        status=[TrackStatus.COASTING, TrackStatus.GROUPED],
    )
    rows = Trajectories.from_tracks([first, second], period, origin_ns=1_000_000_000)
    assert rows.frame.tolist() == [0, 1, 1]
    assert rows.id.tolist() == [7, 7, 8]
    assert rows.position.tolist() == [[1, 2], [1, 2.5], [3, 4.5]]


def test_no_ticks_are_no_rows():
    assert len(Trajectories.from_tracks([], 40_000_000)) == 0


def test_rows_of_some_frames():
    rows = Trajectories([1, 2, 3], [1, 1, 1], np.zeros((3, 2)), ignore=[False, True, False])
    some = rows.at_frames([2, 3])
    assert some.frame.tolist() == [2, 3]
    assert some.ignore.tolist() == [True, False]


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (dict(frame=[1], id=[2], position=[[np.nan, 0]]), 'position of id 2 in frame 1 is'),
        (dict(frame=[1], id=[2], box=[[0, 0, np.inf, 1]]), 'box of id 2 in frame 1 is'),
        (dict(frame=[1, 1], id=[2, 2], position=np.zeros((2, 2))), 'id 2 stands twice in frame 1'),
        (dict(frame=[1, 2], id=[2], position=np.zeros((2, 2))), r'id has shape \(1,\)'),
        (dict(frame=[1], id=[2], position=[[0, 0, 0]]), r'position has shape \(1, 3\)'),
        (dict(frame=[1.5], id=[2], position=[[0, 0]]), 'frame holds values that are not whole'),
        (dict(frame=[1], id=[2]), 'neither a position nor a box'),
    ],
)
def test_bad_rows_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Trajectories(**arguments)
