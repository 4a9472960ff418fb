import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fusion_scenes import PERIOD_NS, detections, published, tick
from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.association.config import ASSOCIATION
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.management.initiation import MOST_TOGETHER
from mctrack_ros.fusion.measurements.admission import MOST_DETECTIONS, usable_rows
from mctrack_ros.interfaces import (
    CameraDetections,
    ClassCode,
    Detections,
    EventCode,
    Rows,
    Tick,
    Ticks,
    TrackStatus,
)

CAMERAS = ('one', 'two')


def run(frames_of, ticks, pipeline=None, start=0):
    pipeline = pipeline or JointTracker(JointConfig(), CAMERAS)
    return [pipeline.step(tick(index, frames_of(index))) for index in range(start, start + ticks)]


def all_rows(frames_of, ticks):
    """Run and return the tracks, events and feedback of each tick."""
    pipeline = JointTracker(JointConfig(), CAMERAS)
    told = []
    for index in range(ticks):
        output = pipeline.step(tick(index, frames_of(index)))
        told.append((output.tracks, output.events, pipeline.feedback()))
    return told


def everything(told):
    return [
        getattr(rows, name).tobytes() for tick in told for rows in tick for name in rows.COLUMNS
    ]


def walkers(index, count=4):
    """Positions of people who walk side by side, 3 m apart."""
    return np.column_stack([np.full(count, index * 0.06), np.arange(count) * 3.0])


def noisy(index, seed=0):
    rng = np.random.default_rng([seed, index])
    return {name: walkers(index) + rng.normal(0, 0.1, (4, 2)) for name in CAMERAS}


def crowded(index, seed=3):
    """People who meet, part and vanish for a while, and false alarms."""
    rng = np.random.default_rng([seed, index])
    people = walkers(index) * (1.0, abs(25 - index % 50) / 25)
    seen = {name: people[rng.random(4) < 0.9] + rng.normal(0, 0.1, (1, 2)) for name in CAMERAS}
    return {
        name: np.vstack([rows if index % 70 < 45 else rows[:1], rng.uniform(-20, 20, (2, 2))])
        for name, rows in seen.items()
    }


@pytest.mark.parametrize('first_id', [2, 2**31 - 100, 2**32 - 10_000])
def test_ids_are_names_that_change_nothing_but_themselves(first_id):
    ids = ('track_id', 'group', 'old_id', 'new_id', 'others', 'previous_id')
    pipelines = [JointTracker(JointConfig(), CAMERAS, first) for first in (1, first_id)]
    for index in range(200):
        outputs = [each.step(tick(index, crowded(index))) for each in pipelines]
        told = [(each.tracks, each.events, p.feedback()) for each, p in zip(outputs, pipelines)]
        for one, other in zip(*told):
            for name in one.COLUMNS:
                wanted, got = getattr(one, name).copy(), getattr(other, name)
                if name in ids:
                    wanted[wanted > 0] += first_id - 1
                np.testing.assert_array_equal(got, wanted, err_msg=name)
    assert pipelines[0].next_id > 100
    assert pipelines[1].next_id == pipelines[0].next_id + first_id - 1


def test_ids_that_run_out_are_an_error_and_not_used_again():
    pipeline = JointTracker(JointConfig(), CAMERAS, 2**32 - 1)
    with pytest.raises(OverflowError, match='ids have run out'):
        pipeline.step(tick(0, noisy(0)))


def test_walkers_are_tracked_with_one_id_each():
    outputs = run(noisy, 50)
    last = published(outputs[-1])
    assert sorted(last) == sorted(published(outputs[10]))
    truth = walkers(49)
    for position in last.values():
        assert np.linalg.norm(truth - position, axis=1).min() < 0.3
    new = sum(int((output.events.event == EventCode.NEW).sum()) for output in outputs)
    assert new == len(last) == 4


def test_one_camera_alone_must_see_longer():
    together = run(lambda index: {'one': [[0, 0]], 'two': [[0.1, 0]]}, 30)
    alone = run(lambda index: {'one': [[0, 0]], 'two': []}, 60)
    first = [next(i for i, out in enumerate(outs) if published(out)) for outs in (together, alone)]
    assert first[0] < first[1]


def test_who_was_long_missed_is_confirmed_as_fast_as_who_just_came():
    def ticks_until_known(seen_by_one_alone):
        pipeline = JointTracker(JointConfig(), (*CAMERAS, 'three'))
        missed = run(
            lambda index: {'one': [[0, 0]], 'two': [], 'three': []}, seen_by_one_alone, pipeline
        )
        assert not any(published(output) for output in missed)
        seen = run(
            lambda index: {'one': [[0, 0]], 'two': [[0.1, 0]], 'three': []},
            30,
            pipeline,
            seen_by_one_alone,
        )
        return next(index for index, output in enumerate(seen) if published(output))

    assert 0 < ticks_until_known(12) <= ticks_until_known(1)


def test_short_loss_keeps_the_id_and_a_long_one_ends_it_once():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 25, pipeline)
    lost = run(lambda index: {'one': [], 'two': []}, 10, pipeline, 25)
    assert (lost[-1].tracks.status == TrackStatus.COASTING).all()
    after = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 5, pipeline, 35)
    assert published(after[-1]).keys() == published(before[-1]).keys()
    ended = run(lambda index: {'one': [], 'two': []}, 60, pipeline, 40)
    deleted = [int((out.tracks.status == TrackStatus.DELETED).sum()) for out in ended]
    exits = [int((out.events.event == EventCode.EXIT).sum()) for out in ended]
    assert sum(deleted) == sum(exits) == 1
    again = run(lambda index: {'one': [[9, 9]], 'two': [[9, 9]]}, 25, pipeline, 100)
    assert not published(again[-1]).keys() & published(before[-1]).keys()


def well_seen(index):
    """What three cameras see of one who stands there for ten seconds and goes."""
    return {name: [[0, 0]] if index < 250 else [] for name in ('one', 'two', 'three')}


def test_whom_cameras_that_saw_him_well_see_no_longer_is_soon_published_no_longer():
    pipeline = JointTracker(JointConfig(), tuple(well_seen(0)))
    (name,) = published(run(well_seen, 250, pipeline)[-1])
    gone = [name in published(output) for output in run(well_seen, 10, pipeline, 250)]
    assert gone == sorted(gone, reverse=True)
    assert 2 <= sum(gone) <= 4
    assert pipeline.feedback().track_id.tolist() == [name]
    once = run(lambda index: well_seen(250) | {'one': [[0, 0]]}, 1, pipeline, 260)
    assert not published(once[-1])
    again = run(
        lambda index: well_seen(250) | {'one': [[0, 0]], 'two': [[0, 0]]}, 1, pipeline, 261
    )
    assert list(published(again[-1])) == [name]


def test_whom_the_only_camera_sees_again_is_published_at_once():
    pipeline = JointTracker(
        JointConfig(management=ManagementConfig(report_time=3, coast_time=3)), ('one',)
    )
    (name,) = published(run(lambda index: {'one': [[0, 0]]}, 250, pipeline)[-1])
    assert not published(run(lambda index: {'one': []}, 50, pipeline, 250)[-1])
    assert list(published(run(lambda index: {'one': [[0, 0]]}, 1, pipeline, 300)[-1])) == [name]


@pytest.mark.parametrize('every', [5, 10])
def test_whom_a_slow_camera_sees_stays_published_though_a_fast_one_does_not(every):
    pipeline = JointTracker(JointConfig(), ('fast', 'slow'))
    run(lambda index: {'fast': [[0, 0]], 'slow': [[0, 0]]}, 250, pipeline)
    slow = run(
        lambda index: {'fast': []} | ({} if index % every else {'slow': [[0, 0]]}),
        250,
        pipeline,
        250,
    )
    assert all(published(output) for output in slow)


def test_a_camera_that_has_stopped_shows_nobody():
    pipeline = JointTracker(JointConfig(), (*well_seen(0), 'dead'))
    run(lambda index: well_seen(0) | {'dead': [[0, 0]]}, 25, pipeline)
    (name,) = published(run(well_seen, 225, pipeline, 25)[-1])
    gone = [name in published(output) for output in run(well_seen, 10, pipeline, 250)]
    assert sum(gone) <= 4


def test_whom_a_slow_camera_sees_in_a_group_stays_published():
    pipeline = JointTracker(JointConfig(), ('fast', 'slow'))
    pair = [[0, 0], [0.8, 0]]
    ids = sorted(published(run(lambda index: {'fast': pair, 'slow': pair}, 250, pipeline)[-1]))

    def slow(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        merged = {} if index % 10 else {'slow': group_row(stamp_ns, [0.4, 0], ids)}
        return {'fast': []} | merged

    assert all(sorted(published(output)) == ids for output in run(slow, 25, pipeline, 250))


def test_one_false_detection_in_an_image_by_itself_does_not_bring_back_who_has_gone():
    pipeline = JointTracker(JointConfig(), tuple(well_seen(0)))
    run(well_seen, 260, pipeline)
    assert not published(run(lambda index: {'one': [[0, 0]]}, 1, pipeline, 260)[-1])


def test_whom_no_camera_could_have_seen_is_published_for_a_while():
    pipeline = JointTracker(JointConfig(), tuple(well_seen(0)))
    run(well_seen, 250, pipeline)
    silent = run(lambda index: {}, 14, pipeline, 250)
    told = int(ManagementConfig().report_time * 1e9 / PERIOD_NS)
    assert [len(published(output)) for output in silent] == [1] * told + [0] * (14 - told)


def test_who_comes_back_where_he_was_soon_after_his_track_ended_is_himself():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 25, pipeline)
    run(lambda index: {'one': [], 'two': []}, 60, pipeline, 25)
    after = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 25, pipeline, 85)
    assert published(after[-1]).keys() == published(before[-1]).keys()
    (corrected,) = [
        out.events.select(out.events.event == EventCode.CORRECTION)
        for out in after
        if EventCode.CORRECTION in out.events.event
    ]
    assert len(corrected) == 1
    assert 0.5 < corrected.probability[0] <= 1.0


def test_an_event_is_as_probable_as_its_track():
    outputs = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 25)
    output = next(out for out in outputs if EventCode.NEW in out.events.event)
    assert output.events.probability.tolist() == output.tracks.score.tolist()
    assert 0.9 < output.events.probability[0] < 1.0


def test_everything_is_sorted_by_id_and_stamped_with_the_tick():
    for index, (tracks, events, feedback) in enumerate(all_rows(noisy, 30)):
        for rows in (tracks, events, feedback):
            assert rows.stamp_ns == index * PERIOD_NS + PERIOD_NS // 2
        for rows in (tracks, feedback):
            assert (np.diff(rows.track_id.astype(int)) > 0).all()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_permuting_detections_changes_nothing(seed):
    def shuffled(index):
        rng = np.random.default_rng([seed, 1, index])
        return {name: rng.permutation(rows) for name, rows in noisy(index, seed).items()}

    straight, mixed = run(lambda index: noisy(index, seed), 25), run(shuffled, 25)
    for one, other in zip(straight, mixed):
        first = np.array(sorted(map(tuple, published(one).values()))).reshape(-1, 2)
        second = np.array(sorted(map(tuple, published(other).values()))).reshape(-1, 2)
        np.testing.assert_allclose(first, second, atol=1e-5)
    assert len(published(straight[-1])) == 4


def test_two_runs_agree_to_the_byte():
    assert everything(all_rows(noisy, 20)) == everything(all_rows(noisy, 20))


def test_covariances_stay_positive_definite():
    for output in run(noisy, 40):
        assert (np.linalg.eigvalsh(output.tracks.covariance.astype(float)) > 0).all()


def group_row(stamp_ns, position, members):
    padded = [*members, *[0] * (16 - len(members))]
    return detections(stamp_ns, [position], 0.5, member_count=[len(members)], members=[padded])


def one_of_a_group(index, place, members):
    """Return what two cameras see: the first one of a group by himself, and that it is one."""
    stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
    rows = [detections(stamp_ns, [place]), group_row(stamp_ns, place, members)]
    return {'one': Detections.joined(stamp_ns, rows), 'two': []}


def test_a_group_keeps_its_members_alive_and_moves_none_of_them_far():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    pair = [[0, 0], [0.8, 0]]
    ids = sorted(published(run(lambda index: {'one': pair, 'two': pair}, 25, pipeline)[-1]))

    def merged(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        return {'one': group_row(stamp_ns, [0.4, 0], ids), 'two': []}

    outputs = run(merged, 75, pipeline, 25)
    assert sorted(published(outputs[-1])) == ids
    assert (outputs[-1].tracks.status == TrackStatus.GROUPED).all()
    assert (outputs[-1].tracks.group == min(ids)).all()
    merges = np.concatenate([out.events.event for out in outputs]) == EventCode.MERGE
    assert merges.sum() == 2
    after = run(lambda index: {'one': pair, 'two': pair}, 10, pipeline, 100)
    assert sorted(published(after[-1])) == ids
    splits = np.concatenate([out.events.event for out in after]) == EventCode.SPLIT
    assert splits.sum() == 2


def test_of_two_images_of_a_camera_the_last_one_begins_tracks():
    images = [
        detections(PERIOD_NS - 9_000_000, [[9, 0], [0, 0]]),
        detections(PERIOD_NS, [[0, 0]]),
    ]
    frames = tuple(CameraDetections('one', rows) for rows in images)
    pipeline = JointTracker(JointConfig(), CAMERAS)
    tracks = pipeline.step(Tick(PERIOD_NS, frames, Ticks.build(PERIOD_NS))).tracks
    np.testing.assert_allclose(tracks.position, [[0, 0, 0]], atol=1e-6)


@pytest.mark.parametrize(('gap', 'code'), [(0.8, EventCode.SPLIT), (3.0, EventCode.NEW)])
def test_who_begins_beside_a_track_has_come_out_of_it(gap, code):
    pipeline = JointTracker(JointConfig(), CAMERAS)
    alone, both = [[0, 0]], [[0, 0], [gap, 0]]
    (first,) = published(run(lambda _: {'one': alone, 'two': alone}, 25, pipeline)[-1])
    outputs = run(lambda _: {'one': both, 'two': both}, 50, pipeline, 25)
    (second,) = published(outputs[-1]).keys() - {first}
    (events,) = [out.events for out in outputs if len(out.events)]
    assert events.event.tolist() == [code]
    assert events.track_id.tolist() == [second]
    assert events.old_id.tolist() == [first if code == EventCode.SPLIT else 0]


def test_a_member_whom_nobody_sees_turns_with_the_one_beside_him():
    def pair(index):
        gone = 0.06 * np.array([min(index, 25), max(index - 25, 0)])
        return np.array([[0, 0], [0.8, -0.8]]) + gone

    pipeline = JointTracker(JointConfig(), CAMERAS)
    ids = sorted(published(run(lambda i: dict.fromkeys(CAMERAS, pair(i)), 25, pipeline)[-1]))
    outputs = run(lambda i: one_of_a_group(i, pair(i)[0], ids), 35, pipeline, 25)
    shown = published(outputs[-1])
    assert sorted(shown) == ids
    np.testing.assert_allclose(shown[ids[1]] - shown[ids[0]], [0.8, -0.8], atol=0.7)


def test_a_member_whom_nobody_sees_is_kept_a_while_beside_one_who_is_seen():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    pair = [[0, 0], [0.8, 0]]
    ids = sorted(published(run(lambda index: {'one': pair, 'two': pair}, 25, pipeline)[-1]))

    outputs = run(lambda index: one_of_a_group(index, pair[0], ids), 100, pipeline, 25)
    (merge,) = [
        out.events.select(out.events.event == EventCode.MERGE)
        for out in outputs
        if EventCode.MERGE in out.events.event
    ]
    assert merge.track_id.tolist() == ids[1:]
    assert merge.others[0, :2].tolist() == [ids[0], 0]
    alive = [sorted(published(output)) for output in outputs]
    assert alive[30] == ids
    assert alive[-1] == ids[:1]


def test_a_group_does_not_keep_who_was_expected_far_from_it():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    pair = [[0, 0], [6, 0]]
    ids = sorted(published(run(lambda index: {'one': pair, 'two': pair}, 25, pipeline)[-1]))

    outputs = run(lambda index: one_of_a_group(index, pair[0], ids), 50, pipeline, 25)
    gone, shown = ids[1], [published(output) for output in outputs]
    assert all(places[gone][0] > 5.5 for places in shown if gone in places)
    assert gone not in shown[20]


def test_a_track_is_as_large_as_the_cameras_say_together():
    sizes = {'one': [0.6, 1.9], 'two': [0.5, 1.7]}
    useless = [[np.nan, np.nan], [np.inf, -1.0], [0.0, 1e30]]

    def sized(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        unknown = useless[index // 4 % len(useless)] if index % 4 == 3 else None
        return {
            name: detections(stamp_ns, [[0, 0]], extent=[unknown or size])
            for name, size in sizes.items()
        }

    pipeline = JointTracker(JointConfig(), CAMERAS)
    tracks = run(sized, 400, pipeline)[-1].tracks
    np.testing.assert_allclose(tracks.extent, [[0.55, 1.8]], atol=0.02)
    np.testing.assert_array_equal(pipeline.feedback().extent, tracks.extent)
    bare = run(lambda index: {'one': [[0, 0]], 'two': [[0, 0]]}, 20)[-1].tracks
    assert np.isnan(bare.extent).all()


def test_a_group_starts_no_track():
    def merged(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        return {name: group_row(stamp_ns, [0.4, 0], [7, 8]) for name in CAMERAS}

    assert all(len(output.tracks) == 0 for output in run(merged, 20))


def test_two_tracks_of_one_target_become_one():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    run(lambda index: {'one': [[0, 0]], 'two': [[2, 0]]}, 30, pipeline)

    def approaching(index):
        return {'one': [[0, 0]], 'two': [[max(0.2, 2 - 0.04 * (index - 30)), 0]]}

    outputs = run(approaching, 90, pipeline, 30)
    assert len(published(outputs[-1])) == 1
    codes = np.concatenate([output.events.event for output in outputs])
    assert (codes == EventCode.CORRECTION).sum() == 1


def test_two_targets_that_a_camera_tells_apart_stay_two():
    near = [[0, 0], [0.4, 0]]
    outputs = run(lambda index: {'one': near, 'two': near}, 60)
    assert len(published(outputs[-1])) == 2


def test_unusable_rows_are_left_out():
    def bad(index):
        stamp_ns = index * PERIOD_NS + PERIOD_NS // 2
        rows = detections(stamp_ns, [[0, 0], [np.nan, 1], [5, 5], [9, 9]])
        covariance = rows.covariance.copy()
        covariance[2] = -1
        covariance[3, 0, 0] = np.inf
        return {'one': rows.replace(covariance=covariance), 'two': [[0, 0]]}

    outputs = run(bad, 20)
    assert len(published(outputs[-1])) == 1
    assert np.isfinite(outputs[-1].tracks.position).all()


def test_time_that_steps_back_ends_all_tracks_and_ids_go_on():
    pipeline = JointTracker(JointConfig(), CAMERAS)
    before = run(noisy, 60, pipeline)
    again = run(noisy, 20, pipeline)
    assert (again[0].tracks.status == TrackStatus.DELETED).sum() == 4
    assert min(published(again[-1])) > max(published(before[-1]))
    with pytest.raises(ValueError, match='the tick is stamped'):
        pipeline.step(tick(18, {}))


def test_empty_ticks_are_no_trouble():
    outputs = run(lambda index: {'one': [], 'two': []}, 3)
    assert all(isinstance(output.tracks, Rows) and len(output.tracks) == 0 for output in outputs)


def test_camera_that_is_not_of_the_site_is_refused():
    with pytest.raises(ValueError, match="camera is 'three'"):
        JointTracker(JointConfig(), CAMERAS).step(tick(0, {'three': [[0, 0]]}))


def test_a_flood_of_detections_is_bounded():
    rng = np.random.default_rng(0)
    pipeline = JointTracker(JointConfig(), CAMERAS)
    spread = [pipeline.step(tick(i, {'one': rng.uniform(-50, 50, (3000, 2))})) for i in range(8)]
    assert max(len(output.tracks) for output in spread) <= JointConfig().management.most_tracks
    pipeline = JointTracker(JointConfig(), CAMERAS)
    spot = [pipeline.step(tick(i, {'one': rng.normal(0, 0.1, (3000, 2))})) for i in range(8)]
    assert max(len(output.tracks) for output in spot) <= 2 * MOST_TOGETHER


def test_of_an_image_the_highest_scores_are_used():
    count = MOST_DETECTIONS + 5
    flood = Detections.build(
        0, position=np.zeros((count, 3)), covariance=np.tile(np.eye(2), (count, 1, 1)),
        score=np.arange(count) / count,
    )  # fmt: skip
    assert np.flatnonzero(~usable_rows(flood)).tolist() == list(range(5))
    far = flood.select(np.arange(1)).replace(position=[[1e9, 0.0, 0.0]])
    assert not usable_rows(far).any()


def test_the_class_is_what_cameras_said_for_longer_however_they_contradict_one_another():
    def kinds(index):
        is_early = index < 60
        return {
            'one': 0 if is_early and index % 3 else ClassCode.PERSON,
            'two': ClassCode.BICYCLE if is_early else 0,
        }

    def seen(index):
        place = np.array([[0.05 * index, 0.0]])
        return {
            name: detections(
                index * PERIOD_NS + PERIOD_NS // 2, place, class_id=np.array([kind], np.uint8)
            )
            for name, kind in kinds(index).items()
        }

    outputs = run(seen, 200)
    told = [int(output.tracks.class_id[0]) for output in outputs if len(output.tracks)]
    assert told[2:50] == [ClassCode.BICYCLE] * 48
    assert told[-1] == ClassCode.PERSON
    assert np.count_nonzero(np.diff(told[2:])) == 1


@pytest.mark.parametrize('every', [1, 2, 3, 5, 10])
@pytest.mark.parametrize('seen_by', [('two',), ('two', 'three')])
def test_whom_only_slow_cameras_see_beside_a_fast_one_is_tracked_all_the_same(every, seen_by):
    def frames(index):
        slow = {name: [[0.04 * index, 5.0]] for name in seen_by} if index % every == 0 else {}
        return {'one': [], **slow}

    pipeline = JointTracker(JointConfig(), (*CAMERAS, 'three'))
    shown = [published(output) for output in run(frames, 100, pipeline)]
    first = next(index for index, known in enumerate(shown) if known)
    assert first * PERIOD_NS < 1.5e9
    assert all(len(known) == 1 for known in shown[first:])
    assert len({name for known in shown for name in known}) == 1


@pytest.mark.parametrize('flooded', ['a', 'z'])
def test_a_flood_of_one_camera_keeps_nobody_else_from_being_tracked(flooded):
    rng = np.random.default_rng(0)
    pipeline = JointTracker(JointConfig(), (flooded, 'm', 'n'))
    place = [[100.0, 0.0]]
    for index in range(25):
        junk = rng.uniform(-50, 50, (300, 2))
        output = pipeline.step(tick(index, {flooded: junk, 'm': place, 'n': place}))
    assert any(np.allclose(where, place[0], atol=0.5) for where in published(output).values())


@pytest.mark.parametrize('count', [3, 8])
def test_cameras_that_share_no_view_track_what_each_sees(count):
    names = tuple(f'cam{index}' for index in range(count))
    pipeline, rng = JointTracker(JointConfig(), names), np.random.default_rng(7)
    place = {name: np.array([20.0 * index, 0.0]) for index, name in enumerate(names)}

    def seen(index):
        walk = np.array([2.0 * np.cos(index / 50), 2.0 * np.sin(index / 50)])
        return {name: (place[name] + walk + rng.normal(0, 0.1, 2))[None] for name in names}

    last = [published(output) for output in run(seen, 250, pipeline)[-50:]]
    assert all(len(told) == count for told in last)


def test_a_camera_that_cannot_tell_who_is_there_misses_nobody():
    """An empty message says that nobody is there; a blind one is as none."""
    names, first = (*CAMERAS, 'three', 'four'), {}
    for others in ('absent', 'blind', 'empty'):
        pipeline = JointTracker(JointConfig(), names)
        for index in range(40):
            rows = {'one': [[0, 0]]}
            if others != 'absent':
                blind = Detections.blind(tick(index, {}).stamp_ns)
                rows |= dict.fromkeys(names[1:], blind if others == 'blind' else [])
            if published(pipeline.step(tick(index, rows))):
                first.setdefault(others, index)
    assert first['blind'] == first['absent']
    assert 'empty' not in first


def test_what_one_of_four_cameras_alone_sees_at_first_is_not_believed_at_once():
    names = (*CAMERAS, 'three', 'four')
    pipeline = JointTracker(JointConfig(), names)
    ghost = run(lambda index: {name: [[0, 0]] * (name == 'one') for name in names}, 65, pipeline)
    assert not any(published(output) for output in ghost)


def test_a_false_detection_in_one_of_three_views_that_are_known_is_not_believed():
    names = ('one', 'two', 'three')
    pipeline = JointTracker(JointConfig(), names)
    run(lambda index: {name: [[0, 0]] for name in names}, 250, pipeline)
    run(lambda index: {name: [] for name in names}, 75, pipeline, 250)
    ghost = run(lambda index: {'one': [[0, 0]], 'two': [], 'three': []}, 750, pipeline, 325)
    assert not any(published(output) for output in ghost)


def test_a_false_detection_of_one_of_three_that_share_a_view_is_not_believed_anywhere():
    names = (*CAMERAS, 'three')
    pipeline = JointTracker(JointConfig(), names)

    def seen(index):
        together = {name: [[0.02 * index, 0.0]] for name in names}
        return together | {'one': [[0.02 * index, 0.0], [30.0, 30.0]]}

    outputs = run(seen, 750, pipeline)
    assert all(len(published(output)) <= 1 for output in outputs)
    assert published(outputs[-1])


@pytest.mark.parametrize('every', [10, 25, 30])
def test_whom_a_slow_camera_alone_sees_is_published_without_a_break(every):
    pipeline, rng = JointTracker(JointConfig(), ('fast', 'slow')), np.random.default_rng(8)

    def seen(index):
        place = np.array([[0.04 * index, 0.0]]) + rng.normal(0, 0.05, (1, 2))
        lost = index % 400 == 200
        return {'fast': []} | ({} if index % every else {'slow': [] if lost else place})

    outputs = run(seen, 1000, pipeline)
    first = next(index for index, output in enumerate(outputs) if published(output))
    assert first <= 10 * every
    ids = {track_id for output in outputs[first:] for track_id in published(output)}
    assert len(ids) == 1
    assert np.mean([len(published(output)) for output in outputs[first:]]) > 0.9


def test_an_untrusted_camera_starts_nobody_but_keeps_whom_others_started():
    pipeline = JointTracker(JointConfig(untrusted='two'), ('one', 'two'))
    place = np.array([[0.0, 0.0]])
    for index in range(30):
        output = pipeline.step(tick(index, {'one': place[:0], 'two': place}))
    assert not len(output.tracks)
    for index in range(30, 60):
        output = pipeline.step(tick(index, {'one': place, 'two': place}))
    assert output.tracks.track_id.tolist() == [1]
    for index in range(60, 120):
        output = pipeline.step(tick(index, {'two': place}))
    assert output.tracks.track_id.tolist() == [1]
    with pytest.raises(ConfigError, match='untrusted names three, expected cameras of one, two'):
        JointTracker(JointConfig(untrusted='two, three'), ('one', 'two'))


@pytest.mark.parametrize('method', ['weighed_gnn', 'covering_graph'])
def test_detections_in_no_gate_are_told_from_those_whose_tracks_took_others(method):
    kind = ASSOCIATION.methods[method]
    pipeline = JointTracker(JointConfig(association=kind(method)), CAMERAS)
    first, *_ = run(lambda index: {name: walkers(index, 2) for name in CAMERAS}, 25, pipeline)
    assert first.gates.in_no_gate.tolist() == [2, 2]
    two = walkers(25, 2)
    seen = [*two, two[0] + (0.2, 0.0), two[1] + (0.0, 0.2), two[0] - (0.0, 9.0)]
    gates = pipeline.step(tick(25, {'one': seen})).gates
    assert gates.detections.tolist() == [5, 0]
    assert gates.in_no_gate.tolist() == [1, 0]
    assert gates.taken_by_others.tolist() == [2, 0]
    assert pipeline.step(tick(26, {})).gates.detections.tolist() == [0, 0]
