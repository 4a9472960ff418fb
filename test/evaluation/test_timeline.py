import numpy as np

from mctrack_ros.evaluation import Trajectories, evaluate_ground, ground_timeline


def example():
    truth = Trajectories(
        [1, 2, 2, 3, 5], [7, 7, 8, 7, 7], [[0, 0], [0, 0], [9, 0], [0, 0], [0, 0]]
    )
    tracks = Trajectories(
        [1, 2, 2, 4, 5], [1, 1, 5, 2, 3], [[0, 0.5], [0, 0], [9, 1], [0, 0], [0, 0]]
    )
    return truth, tracks


def test_counts_errors_and_switches_have_their_frames():
    line = ground_timeline(*example(), 1.0)
    assert line.frame.tolist() == [1, 2, 3, 4, 5]
    assert line.truth.tolist() == [1, 2, 1, 0, 1]
    assert line.tracks.tolist() == [1, 2, 0, 1, 1]
    assert line.matched.tolist() == [1, 2, 0, 0, 1]
    np.testing.assert_allclose(line.error_m, [0.5, 0.5, np.nan, np.nan, 0.0])
    assert line.switch_frame.tolist() == [5]
    assert line.switch_truth_id.tolist() == [7]
    assert line.switch_track_id.tolist() == [3]


def test_timeline_adds_up_to_the_scores():
    line, scores = ground_timeline(*example(), 1.0), evaluate_ground(*example(), 1.0)
    assert len(line.switch_frame) == scores.switches
    assert (line.truth - line.matched).sum() == scores.misses
    assert (line.tracks - line.matched).sum() == scores.false_positives


def test_track_on_someone_who_has_one_already_is_a_duplicate():
    truth = Trajectories([1, 1], [1, 2], [[0, 0], [5, 0]])
    tracks = Trajectories([1] * 4, [1, 2, 3, 4], [[0, 0], [0.5, 0], [5, 0], [9, 0]])
    line = ground_timeline(truth, tracks, 1.0)
    assert (line.tracks - line.matched).tolist() == [2]
    assert line.duplicates.tolist() == [1]


def test_nothing_gives_an_empty_timeline():
    empty = Trajectories([], [])
    assert len(ground_timeline(empty, empty, 1.0).frame) == 0
