import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.evaluation import Trajectories, evaluate_boxes, evaluate_ground


def on_line(*rows):
    """Make trajectories of (frame, id, x) on the line y = 0."""
    table = np.array(rows, np.float64).reshape(-1, 3)
    position = np.stack([table[:, 2], np.zeros(len(table))], axis=1)
    return Trajectories(table[:, 0], table[:, 1], position)


def random_pair(seed, frames=12, people=4):
    """Make truth and tracks with noise, gaps and changes of identity."""
    rng = np.random.default_rng(seed)
    frame, person = np.repeat(np.arange(frames), people), np.tile(np.arange(people), frames)
    walks = np.cumsum(rng.normal(0, 0.3, (frames, people, 2)), axis=0) + rng.uniform(0, 4, (2,))
    position = walks.reshape(-1, 2)
    seen, there = rng.random(len(frame)) > 0.2, rng.random(len(frame)) > 0.1
    truth = Trajectories(frame[there], person[there], position[there])
    label = rng.permutation(2 * people)[person + people * (frame > frames // 2)]
    moved = position + rng.normal(0, 0.3, position.shape)
    return truth, Trajectories(frame[seen], label[seen], moved[seen])


def test_hand_computed_table():
    # frame   truth 1   track    truth 2   track
    #   1     0.0       10 .3    5.0       20 .0
    #   2     0.0       10 .5    5.0       -
    #   3     0.0       11 .1    5.0       20 .4     and 30 far from anyone
    #   4     0.0       11 .1    -         -
    truth = on_line((1, 1, 0), (2, 1, 0), (3, 1, 0), (4, 1, 0), (1, 2, 5), (2, 2, 5), (3, 2, 5))
    tracks = on_line(
        (1, 10, 0.3), (2, 10, 0.5), (3, 11, 0.1), (4, 11, 0.1), (1, 20, 5), (3, 20, 5.4)
    )
    tracks = Trajectories(
        np.append(tracks.frame, 3),
        np.append(tracks.id, 30),
        np.vstack([tracks.position, [[9.0, 0.0]]]),
    )
    scores = evaluate_ground(truth, tracks, 1.0)
    assert (scores.switches, scores.misses, scores.false_positives) == (1, 1, 1)
    assert scores.mota == pytest.approx(1 - 3 / 7)
    assert scores.mean_distance == pytest.approx((0.3 + 0.5 + 0.1 + 0.1 + 0.0 + 0.4) / 6)
    assert scores.motp == pytest.approx(1 - scores.mean_distance)
    assert scores.moda == pytest.approx(1 - 2 / 7)
    assert scores.modp == pytest.approx(scores.motp)
    assert (scores.precision, scores.recall) == pytest.approx((6 / 7, 6 / 7))
    assert scores.idf1 == pytest.approx(2 * 4 / (7 + 7))
    assert scores.fragmentations == 1
    assert (scores.mostly_tracked, scores.partially_tracked, scores.mostly_lost) == (1, 1, 0)
    assert (scores.frames, scores.truth_ids, scores.truth_rows, scores.track_rows) == (4, 2, 7, 7)


def test_perfect_tracks_score_one():
    truth, _ = random_pair(0)
    scores = evaluate_ground(truth, truth, 0.5)
    for name in ('mota', 'motp', 'idf1', 'hota', 'deta', 'assa', 'loca', 'moda', 'modp'):
        assert getattr(scores, name) == pytest.approx(1.0), name


def test_a_pair_once_matched_is_carried_over_though_another_is_nearer():
    truth = on_line((1, 1, 0), (2, 1, 0))
    tracks = on_line((1, 10, 0), (2, 10, 0.8), (2, 11, 0.1))
    scores = evaluate_ground(truth, tracks, 1.0)
    assert scores.switches == 0
    assert scores.mean_distance == pytest.approx(0.4)
    assert scores.modp == pytest.approx(1 - (0.0 + 0.1) / 2)


def test_detection_scores_carry_nothing_over():
    # Frame 2: keeping 1-10 leaves 2 without a partner; matched afresh both have one.
    truth = on_line((1, 1, 0.0), (2, 1, 0.0), (2, 2, 1.8))
    tracks = on_line((1, 10, 0.0), (2, 10, 0.9), (2, 11, -0.9))
    scores = evaluate_ground(truth, tracks, 1.0)
    assert (scores.misses, scores.false_positives) == (1, 1)
    assert scores.moda == 1.0


def test_hota_of_a_track_that_changes_its_id_half_way():
    # DetA = 1 at every alpha; each half overlaps 2 of 4 frames: AssA = 0.5.
    truth = on_line(*((frame, 1, 0) for frame in range(4)))
    tracks = on_line(*((frame, 10 + frame // 2, 0) for frame in range(4)))
    scores = evaluate_ground(truth, tracks, 1.0)
    assert (scores.deta, scores.assa) == pytest.approx((1.0, 0.5))
    assert scores.hota == pytest.approx(np.sqrt(0.5))


def test_hota_counts_a_pair_at_the_gate_up_to_alpha_one_half():
    # Similarity 1 - 1 / 2 = 0.5: matched at alpha 0.05 ... 0.50, which are 10 of 19.
    scores = evaluate_ground(on_line((0, 1, 0)), on_line((0, 5, 1)), 1.0)
    assert scores.hota == pytest.approx(10 / 19)


@pytest.mark.parametrize('seed', range(6))
def test_idf1_is_that_of_the_best_assignment_of_tracks(seed):
    truth, tracks = random_pair(seed, people=3)
    true_ids, track_ids = np.unique(truth.id), np.unique(tracks.id)
    together = np.zeros((len(true_ids), len(track_ids)))
    for row, column in itertools.product(range(len(truth)), range(len(tracks))):
        near = np.linalg.norm(truth.position[row] - tracks.position[column]) <= 0.7
        if near and truth.frame[row] == tracks.frame[column]:
            true_index = np.searchsorted(true_ids, truth.id[row])
            together[true_index, np.searchsorted(track_ids, tracks.id[column])] += 1
    best = max(
        sum(together[row, column] for row, column in enumerate(columns))
        for columns in itertools.permutations(range(len(track_ids)), len(true_ids))
    )
    scores = evaluate_ground(truth, tracks, 0.7)
    assert scores.idf1 == pytest.approx(2 * best / (len(truth) + len(tracks)))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_names_and_order_of_rows_change_nothing(seed):
    truth, tracks = random_pair(seed)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(tracks))
    names = rng.permutation(100)
    renamed = Trajectories(tracks.frame[order], names[tracks.id[order]], tracks.position[order])
    before, after = evaluate_ground(truth, tracks, 0.7), evaluate_ground(truth, renamed, 0.7)
    assert after.figures() == pytest.approx(before.figures(), nan_ok=True)


def test_ignored_truth_and_the_track_on_it_count_neither_way():
    truth = on_line((1, 1, 0), (1, 2, 5), (2, 1, 0))
    ignored = Trajectories(truth.frame, truth.id, truth.position, ignore=truth.id == 2)
    scores = evaluate_ground(ignored, on_line((1, 7, 0.1), (1, 8, 5.1), (2, 7, 0)), 1.0)
    assert (scores.mota, scores.hota > 0.9, scores.truth_rows, scores.track_rows) == (
        1,
        True,
        2,
        2,
    )


def test_gate_itself_is_a_match():
    truth = on_line((1, 1, 0))
    assert evaluate_ground(truth, on_line((1, 2, 1)), 1.0).misses == 0
    assert evaluate_ground(truth, on_line((1, 2, 1.001)), 1.0).misses == 1


def test_no_tracks_miss_everything():
    scores = evaluate_ground(on_line((1, 1, 0), (2, 1, 0)), on_line(), 1.0)
    assert (scores.mota, scores.moda, scores.hota, scores.idf1, scores.misses) == (0, 0, 0, 0, 2)
    assert np.isnan(scores.motp)


def test_without_truth_ratios_do_not_exist():
    scores = evaluate_ground(on_line(), on_line((1, 1, 0)), 1.0)
    assert scores.false_positives == 1
    assert np.isnan([scores.moda, scores.hota, scores.recall]).all()


def test_boxes_match_by_their_overlap():
    truth = Trajectories([1, 2], [1, 1], box=[[0, 0, 10, 10], [0, 0, 10, 10]])
    tracks = Trajectories([1, 2], [4, 4], box=[[0, 0, 10, 5], [0, 0, 10, 4.9]])
    scores = evaluate_boxes(truth, tracks)
    assert (scores.misses, scores.false_positives) == (1, 1)
    assert scores.motp == pytest.approx(0.5)


def test_bad_gates_and_missing_geometry_are_refused():
    truth, boxes = on_line((1, 1, 0)), Trajectories([1], [1], box=[[0, 0, 1, 1]])
    with pytest.raises(ValueError, match='the gate is 0 m'):
        evaluate_ground(truth, truth, 0)
    with pytest.raises(ValueError, match='tracks has no position'):
        evaluate_ground(truth, boxes, 1.0)
    with pytest.raises(ValueError, match='IoU threshold is 1'):
        evaluate_boxes(boxes, boxes, 1)


@pytest.mark.real_data
def test_official_scores_of_tud_stadtmitte_are_reproduced(data_root):
    folder = data_root / 'evaluator_check_tud'
    truth, tracks = (
        np.loadtxt(folder / name, delimiter=',')
        for name in ('TUD-Stadtmitte_gt.txt', 'CEM_TUD-Stadtmitte.txt')
    )
    scores = evaluate_boxes(
        Trajectories(truth[:, 0], truth[:, 1], box=truth[:, 2:6], ignore=truth[:, 6] == 0),
        Trajectories(tracks[:, 0], tracks[:, 1], box=tracks[:, 2:6]),
    )
    assert (scores.false_positives, scores.misses, scores.switches) == (45, 452, 7)
    assert (scores.mostly_tracked, scores.mostly_lost, scores.fragmentations) == (5, 1, 6)
    assert scores.truth_ids == 10
    percent = [round(100 * value, 1) for value in (scores.recall, scores.precision, scores.motp)]
    assert percent == [60.9, 94.0, 65.4]
    assert round(100 * scores.idf1, 2) == 64.46
    assert round(100 * scores.mota, 2) == 56.40
    # By TrackEval 1.3.0, the reference code of HOTA's authors, on the same files.
    reference = (0.3978490169927877, 0.3922675723693166, 0.4088407518112996, 0.737521177178062)
    found = (scores.hota, scores.deta, scores.assa, scores.loca)
    assert found == pytest.approx(reference, abs=1e-12)
