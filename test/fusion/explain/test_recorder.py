"""What is taken down of a tick is what it was decided by, and taking it down changes nothing."""

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections, published, tick
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.fusion import DecisionRecorder, JointConfig, JointTracker
from mctrack_ros.fusion.association.config import ASSOCIATION
from mctrack_ros.fusion.association.joint import JointAssociation
from mctrack_ros.fusion.association.likelihood import prior_costs
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Pairs
from mctrack_ros.fusion.explain.decisions import decisions_of
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.covering import CoveringAssociation
from mctrack_ros.interfaces import (
    Candidates,
    Choice,
    Decisions,
    Reason,
    TrackStatus,
)
from mctrack_ros.recording import ROSBAGS_CLASSES

CONFIG = JointConfig()
CAMERAS = ('one', 'two')


def explained(frames_of, ticks, pipeline=None, start=0):
    """Return what each tick gives, and its explanation."""
    pipeline = pipeline or JointTracker(CONFIG, CAMERAS)
    told = []
    for index in range(start, start + ticks):
        recorder = DecisionRecorder()
        told.append((pipeline.step(tick(index, frames_of(index)), recorder), recorder.explanation))
    return told


def crowd(index):
    """Return people who stand so close that their detections are taken for one another's."""
    rng = np.random.default_rng(index)
    places = np.array([[0, 0], [0.5, 0], [1.0, 0.2]])
    return {name: places + rng.normal(0, 0.2, (3, 2)) for name in CAMERAS}


def scene(seed):
    """Return a table and images of a crowd, one of them taken earlier."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 2, (6, 2))
    table = TrackTable.blank(6, 3)
    table.track_id[:] = np.arange(1, 7)
    table.mean[:, :2], table.mean[:, 2:] = places, rng.normal(0, 1, (6, 2))
    table.covariance[:] = np.diag([0.09, 0.09, 1.0, 1.0])
    table.confirmed[:4] = True
    images = [
        detections(PERIOD_NS - before_ns, places + rng.normal(0, 0.2, (6, 2)), local_id=range(6))
        for before_ns in (0, 0, 30_000_000)
    ]
    return table, Batch(images, [0, 1, 2], PERIOD_NS, CONFIG)


@pytest.mark.parametrize('method', sorted(ASSOCIATORS.keys() - {'covering_graph'}))
@pytest.mark.parametrize('seed', range(3))
def test_judged_pairs_give_the_probabilities_that_were_used(method, seed):
    table, batch = scene(seed)
    config = ASSOCIATION.made(method)
    joint = JointAssociation(table, batch, config)
    joint.solve()
    judged = joint.judged(table, batch, config)
    single = np.searchsorted(batch.single, judged.row)
    cost = judged.squared + np.log(np.linalg.det(judged.spread + batch.noise[judged.row]))
    cost += prior_costs(table, batch, judged.track, single, config)
    near = judged.squared < config.gate
    slots = np.unique(batch.image[judged.row[near]] * 6 + judged.track[near], return_inverse=True)
    pairs = Pairs(
        *(judged.track[near], single[near], slots[1]),
        *(np.exp(-cost[near] / 2), batch.image[judged.row[near]]),
    )
    np.testing.assert_allclose(cost, judged.squared + sum(judged.costs.values()), rtol=1e-9)
    expected = ASSOCIATORS[method]().probabilities(pairs)
    np.testing.assert_allclose(judged.probability[near], expected, atol=1e-6)
    assert not judged.probability[~near].any()
    track, row = joint.pairs()
    assert judged.track[judged.taken].tolist() == track.tolist()
    assert judged.row[judged.taken].tolist() == row.tolist()


def test_pairs_of_the_covering_graph_are_told_too():
    table, batch = scene(1)
    config = ASSOCIATION.made('covering_graph')
    covering = CoveringAssociation(table, batch, config)
    judged = covering.judged(table, batch, config)
    track, row = covering.pairs()
    assert judged.track[judged.taken].tolist() == track.tolist()
    assert judged.row[judged.taken].tolist() == row.tolist()
    assert (judged.squared < config.gate).all()


def test_an_account_changes_nothing():
    pipeline = JointTracker(CONFIG, CAMERAS)
    for index, (output, _) in enumerate(explained(crowd, 40)):
        other = pipeline.step(tick(index, crowd(index)))
        for name in ('tracks', 'events'):
            one, two = getattr(output, name), getattr(other, name)
            assert all(
                getattr(one, column).tobytes() == getattr(two, column).tobytes()
                for column in one.COLUMNS
            )


def test_every_detection_is_accounted_for_and_travels():
    for index, (_, why) in enumerate(explained(crowd, 20)):
        told = set(zip(why.candidates.camera.tolist(), why.candidates.detection.tolist()))
        assert told == {(camera, row) for camera in range(2) for row in range(3)}
        taken = why.candidates.select(why.candidates.choice == Choice.TAKEN)
        frames = crowd(index)
        for camera, row, place in zip(taken.camera, taken.detection, taken.position):
            np.testing.assert_allclose(place[:2], frames[CAMERAS[camera]][row], atol=1e-6)
        for rows, kind in ((why.candidates, Candidates), (why.decisions, Decisions)):
            again = rows_from_cloud(cloud_from_rows(rows, ROSBAGS_CLASSES, 'map'), kind)
            assert all(
                getattr(again, name).tobytes() == getattr(rows, name).tobytes()
                for name in kind.COLUMNS
            )


def test_the_cost_is_what_the_probability_was_made_of():
    _, why = explained(lambda _: {'one': [[0, 0]], 'two': [[0, 0]]}, 30)[-1]
    likelihood = np.exp(-why.candidates.cost / 2)
    np.testing.assert_allclose(
        why.candidates.probability, likelihood / (1 + likelihood), rtol=1e-4
    )


def test_a_life_is_told_from_its_begin_to_its_end():
    def frames(index):
        place = [[0.02 * index, 0]] if index < 30 else []
        return {'one': place, 'two': place}

    told = [why.decisions for _, why in explained(frames, 70)]
    reasons = [Reason(each.reason[0]) for each in told if len(each)]
    changes = [one for one, before in zip(reasons, [None, *reasons]) if one != before]
    names = ['BEGAN', 'SEEN', 'CONFIRMED', 'SEEN', 'COASTS', 'SILENT']
    assert [each.name for each in changes] == names
    assert np.isnan(told[0].predicted).all()
    assert np.isfinite(told[1].predicted).all()
    last = next(each for each in told if Reason.SILENT in each.reason)
    assert last.value[0] > last.limit[0] == CONFIG.management.coast_time


def test_detections_that_begin_a_track_and_those_that_do_not_are_told():
    pipeline = JointTracker(CONFIG, CAMERAS)
    _, why = explained(lambda _: {'one': [[0, 0], [9, 0]], 'two': [[0.1, 0]]}, 1, pipeline)[0]
    assert why.candidates.choice.tolist() == [Choice.BEGINS] * 3
    ids = dict(zip(why.decisions.track_id.tolist(), why.decisions.position[:, 0].tolist()))
    for track_id, place in zip(why.candidates.track_id.tolist(), why.candidates.position):
        assert abs(place[0] - ids[track_id]) < 0.2


def test_who_is_hidden_by_a_group_is_told():
    pipeline = JointTracker(CONFIG, CAMERAS)
    pair = [[0, 0], [0.8, 0]]
    before = explained(lambda _: {'one': pair, 'two': pair}, 25, pipeline)
    ids = sorted(published(before[-1][0]))
    members = [[*ids, *[0] * 14]]

    def merged(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        group = detections(stamp_ns, [[0.4, 0]], 0.5, member_count=[2], members=members)
        return {'one': group, 'two': []}

    _, why = explained(merged, 3, pipeline, 25)[-1]
    assert why.candidates.choice.tolist() == [Choice.HIDES] * 2
    assert why.candidates.track_id.tolist() == ids
    assert why.decisions.reason.tolist() == [Reason.HIDDEN] * 2


def test_a_group_that_hides_nobody_is_told_as_unused():
    group = detections(PERIOD_NS // 2, [[7, 3]], member_count=[2])
    _, why = explained(lambda _: {'one': [], 'two': group}, 1)[0]
    assert why.candidates.choice.tolist() == [Choice.UNUSED]
    assert why.candidates.track_id.tolist() == [0]
    assert why.candidates.camera.tolist() == [1]
    np.testing.assert_allclose(why.candidates.position[0, :2], [7, 3])


def test_a_detection_that_there_is_no_room_for_is_told_as_unused():
    pipeline = JointTracker(JointConfig(management=ManagementConfig(most_tracks=1)), CAMERAS)
    _, why = explained(lambda index: {'one': [[0, 0], [9, 0]][: index + 1]}, 2, pipeline)[-1]
    told = dict(zip(why.candidates.choice.tolist(), why.candidates.track_id.tolist()))
    assert told == {Choice.TAKEN: 1, Choice.UNUSED: 0}


def test_a_step_back_in_time_ends_all_and_says_so():
    pipeline = JointTracker(CONFIG, CAMERAS)
    explained(lambda _: {'one': [[0, 0]], 'two': [[0, 0]]}, 20, pipeline, 100)
    _, why = explained(lambda _: {'one': [], 'two': []}, 1, pipeline)[0]
    assert why.decisions.reason.tolist() == [Reason.RESET]


def test_renamed_and_joined_tracks_name_the_other():
    table, ended = TrackTable.blank(3, 2), TrackTable.blank(1, 2)
    table.track_id[:], table.previous_id[:] = [3, 5, 8], [0, 8, 9]
    table.confirmed[:] = table.cameras[:] = 1
    ended.track_id[:] = 9
    predicted = TrackTable.blank(4, 2)
    predicted.track_id[:], predicted.confirmed[:] = [3, 5, 8, 9], True
    predicted.mean[:, 0] = [3, 5, 8, 9]
    recognition = Reassignment(CONFIG)
    decisions, called = decisions_of(
        table, ended, predicted, np.zeros(0, np.uint32), recognition, 0, CONFIG
    )
    assert called == {8: 5}
    assert decisions.track_id.tolist() == [3, 5, 8, 9]
    assert decisions.reason.tolist() == [
        Reason.SEEN, Reason.RECOGNISED, Reason.ABSORBED, Reason.JOINED
    ]  # fmt: skip
    assert decisions.previous_id.tolist() == [0, 8, 0, 0]
    assert decisions.other_id.tolist() == [0, 8, 9, 8]
    assert decisions.predicted[:, 0].tolist() == [3, 8, 8, 9]


def test_what_is_known_of_each_track_goes_with_its_decision():
    rng, now_ns = np.random.default_rng(3), 90_000_000_000
    table = TrackTable.blank(2, 2)
    table.track_id[:], table.confirmed[:] = [3, 5], True
    table.mean[:], table.covariance[:] = rng.normal(size=(2, 4)), rng.normal(size=(2, 4, 4))
    table.evidence[:], table.missed[:] = rng.normal(size=(2, 2))
    table.group[:], table.cameras[:] = [3, 0], [0, 2]
    for name, seconds in (('first_ns', [60, 9]), ('seen_ns', [4, 2]), ('kept_ns', [0.25, 0.5])):
        setattr(table, name, now_ns - np.array(seconds) * 1e9)
    predicted, recognition = table.select(np.array([1])), Reassignment(CONFIG)
    predicted.track_id[:] = table.previous_id[1] = 1
    predicted.mean[:], predicted.covariance[:] = 7.0, rng.normal(size=(4, 4))
    told, _ = decisions_of(
        *(table, TrackTable.blank(0, 2), predicted, np.zeros(0, np.uint32)),
        *(recognition, now_ns, CONFIG),
    )
    expected = {
        'previous_id': [0, 1],
        'velocity': table.mean[:, 2:],
        'covariance': table.covariance[:, :2, :2],
        'age': [60, 9],
        'unseen': [4, 2],
        'unsupported': [0.25, 0.5],
        'group': [3, 0],
        'cameras': [0, 2],
        'status': [TrackStatus.GROUPED, TrackStatus.CONFIRMED],
        'evidence': table.evidence,
        'missed': table.missed,
        'predicted': [[np.nan, np.nan], [7, 7]],
        'predicted_covariance': [np.full((2, 2), np.nan), predicted.covariance[0, :2, :2]],
    }
    for name, values in expected.items():
        np.testing.assert_allclose(getattr(told, name), values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(told.position[:, :2], table.mean[:, :2], rtol=1e-6)


def test_who_ended_was_silent_or_not_seen_where_he_should_have_been():
    """By evidence below nothing of one who was confirmed, by silence else."""
    now_ns, nobody = 90_000_000_000, TrackTable.blank(0, 2)
    ended = TrackTable.blank(4, 2)
    ended.track_id[:], ended.kept_ns[:] = [1, 2, 3, 4], now_ns - 5_000_000_000
    ended.confirmed[:], ended.evidence[:] = [True, True, True, False], [-0.5, 0, 3, -0.5]
    reset = np.zeros(0, np.uint32)
    told, _ = decisions_of(nobody, ended, nobody, reset, Reassignment(CONFIG), now_ns, CONFIG)
    assert told.reason.tolist() == [Reason.UNSEEN, *[Reason.SILENT] * 3]
    assert told.value.tolist() == [-0.5, 5, 5, 5]
    coast, tentative = CONFIG.management.coast_time, CONFIG.management.tentative_time
    np.testing.assert_allclose(told.limit, [0, coast, coast, tentative], rtol=1e-6)
    assert told.status.tolist() == [TrackStatus.DELETED] * 4
    assert told.is_published.all()


def test_who_was_lost_and_is_found_where_he_would_be_by_now_is_told():
    def frames(index):
        place = [] if 30 <= index < 75 else [[0.04 * index, 0]]
        return {'one': place, 'two': place}

    told = explained(frames, 100)
    found = [
        (why.decisions, out.tracks)
        for out, why in told
        if Reason.REAPPEARED in why.decisions.reason
    ]
    assert len(found) == 1
    decisions, tracks = found[0]
    assert decisions.track_id.tolist() == tracks.track_id.tolist() == [1]
    assert decisions.other_id.tolist() == decisions.previous_id.tolist() == [2]
    assert decisions.value[0] < decisions.limit[0] == 0.0
    assert np.isfinite(decisions.predicted).all()
