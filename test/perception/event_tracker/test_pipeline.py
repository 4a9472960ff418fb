import cv2
import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception import (
    BackwardStampError,
    EventTracker,
    EventTrackerConfig,
    ShiftState,
)
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig

RED, BLUE, WHITE = (30, 30, 220), (220, 60, 30), (240, 240, 240)


def events_of(outputs):
    return [int(event) for output in outputs for event in output.events.event]


def empty(mapping):
    """Return the stage without anybody, and without noise."""
    return np.full((*mapping.image_size[::-1], 3), (60, 120, 60), np.uint8)


def test_person_is_found_where_it_stands(stage):
    for step in range(20):
        output = stage.show([((0.1 * step, 1.0), RED)])
    detections = output.detections
    assert len(detections) == 1
    assert np.allclose(detections.position[0, :2], [1.9, 1.0], atol=0.25)
    assert detections.score[0] == 1
    assert detections.local_id[0] == 1


def test_predicted_box_lies_on_the_person(stage):
    for _ in range(10):
        box = stage.show([((1.0, 0.0), RED)]).detections.box[0]
    assert np.allclose(stage.pipeline.predicted_boxes(), [box], atol=2.0)
    moved = stage.show([((1.4, 0.0), RED)]).detections.box[0]
    assert moved[0] - box[0] > 5.0
    assert np.allclose(stage.pipeline.predicted_boxes(), [box], atol=2.0)


def test_with_a_given_background_people_are_seen_at_once(new_stage, mapping):
    stage = new_stage()
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping, background=empty(mapping))
    assert len(stage.show([((1.0, 0.0), RED)]).detections) == 1


def test_empty_scene_gives_empty_detections(stage):
    assert len(stage.show([]).detections) == 0


def test_covariance_is_honest_and_positive_definite(stage):
    errors = []
    for step in range(60):
        x, y = -3 + 0.1 * step, -2 + 0.1 * step
        detections = stage.show([((x, y), RED)]).detections
        if len(detections):
            assert (np.linalg.eigvalsh(detections.covariance) > 0).all()
            difference = detections.position[0, :2] - [x, y]
            errors.append(difference @ np.linalg.solve(detections.covariance[0], difference))
    assert np.mean(errors) < 3.0


def test_whose_feet_are_seen_unsteadily_is_less_certain(new_stage):
    def variance(jitter_m, **settings):
        rng, stage = np.random.default_rng(3), new_stage(filter=settings)
        for _ in range(75):
            place = (rng.normal(0.0, jitter_m), 1.0 + rng.normal(0.0, jitter_m))
            detections = stage.show([(place, RED)]).detections
        return np.trace(detections.covariance[0])

    steady = variance(0.0)
    assert variance(0.35) > 2 * steady
    assert variance(0.35, noise_time_s=0.0) < 1.5 * steady


def test_known_target_enters_and_one_told_of_later_is_new(stage):
    def reported(stamp_ns):
        count = 2 if len(outputs) > 20 else 1
        return Feedback.build(
            stamp_ns - 80_000_000,
            position=[[-2.0, 1.0, 0.0], [2.0, 1.0, 0.0]][:count],
            covariance=[np.eye(4) * 0.1] * count,
            track_id=[77, 78][:count],
        )

    outputs = []
    for _ in range(60):
        people = [((-2.0, 1.0), RED), ((2.0, 1.0), BLUE), ((5.0, 1.0), RED)]
        outputs.append(stage.show(people, reported))
    found = {
        int(output.events.event[row]): int(output.events.track_id[row])
        for output in outputs
        for row in np.flatnonzero(output.events.event < EventCode.STABLE).tolist()
    }
    assert found == {EventCode.ENTER: 77, EventCode.NEW: 78}
    assert sorted(outputs[-1].detections.track_id.tolist()) == [0, 77, 78]


def walk_past(stage, steps=80):
    """Two people cross, one close behind the other."""
    return [
        stage.show([((-3 + 0.075 * step, 0.0), RED), ((3 - 0.075 * step, 0.6), BLUE)])
        for step in range(steps)
    ]


def test_crossing_is_one_merge_and_one_split_and_ids_survive(stage):
    outputs = walk_past(stage)
    events = events_of(outputs)
    assert events.count(EventCode.MERGE) == 1
    assert events.count(EventCode.SPLIT) == 1
    before, after = outputs[15].detections, outputs[-1].detections
    assert np.argsort(before.position[:, 0]).tolist() == [0, 1]
    left, right = before.local_id[np.argsort(before.position[:, 0])]
    assert after.local_id[np.argsort(after.position[:, 0])].tolist() == [right, left]


def test_people_in_one_blob_are_told_apart(stage):
    for step in range(40):
        x = -2 + 0.05 * step
        output = stage.show([((x, 0.0), RED), ((x + 0.65, 0.1), BLUE)])
    position = output.detections.position
    assert len(position) == 2
    assert np.allclose(np.sort(position[:, 0]), [x, x + 0.65], atol=0.3)


def test_who_stood_still_at_first_leaves_no_ghost(new_stage, mapping):
    stage = new_stage()
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping)
    for _ in range(40):
        stage.show([((-1.0, 0.0), RED)])
    for step in range(60):
        output = stage.show([((-1.0 + 0.05 * step, 0.0), RED)])
    assert len(output.detections) == 1
    assert abs(output.detections.position[0, 0] - 1.95) < 0.3


def test_leaving_the_image_is_an_exit(stage):
    outputs = [stage.show([((2 + 0.12 * step, -2.0), RED)]) for step in range(60)]
    assert EventCode.EXIT in events_of(outputs)
    assert not len(outputs[-1].detections)


def test_local_ids_are_never_reused(stage):
    seen = []
    for _ in range(3):
        for _ in range(10):
            output = stage.show([((0.0, 0.0), RED)])
        seen += output.detections.local_id.tolist()
        stage.empty(2.0)
    assert len(set(seen)) == 3


def test_gap_restarts_tracks_but_not_ids(stage):
    for _ in range(10):
        first = stage.show([((0.0, 0.0), RED)])
    stage.index += 100
    for _ in range(10):
        second = stage.show([((0.0, 0.0), RED)])
    assert second.detections.local_id[0] > first.detections.local_id[0]


@pytest.mark.parametrize('rate_hz', [0.5, 1.0])
def test_a_slow_camera_keeps_who_is_in_view(stage, mapping, rate_hz):
    pipeline = EventTracker(EventTrackerConfig(), mapping, background=empty(mapping))
    rng, ids = np.random.default_rng(4), []
    for step in range(30):
        image = stage.image([((0.3 * np.sin(step), 1.0), RED)])
        stamp_s = 10 + (step + rng.uniform(0.0, 0.1)) / rate_hz
        ids += pipeline.step(image, round(stamp_s * 1e9), None).detections.local_id.tolist()
    assert len(ids) == 30
    assert len(set(ids[2:])) == 1


def test_same_images_give_the_same_output(new_stage):
    first, second = walk_past(new_stage(), 30), walk_past(new_stage(), 30)
    for one, other in zip(first, second):
        for name in one.detections.COLUMNS:
            assert np.array_equal(getattr(one.detections, name), getattr(other.detections, name))


@pytest.mark.parametrize(
    ('image', 'reason'),
    [
        (np.zeros((100, 320, 3), np.uint8), 'image is 320 x 100, expected 320 x 240'),
        (np.zeros((240, 320), np.uint8), r'image has shape \(240, 320\)'),
        (np.zeros((0, 0, 3), np.uint8), 'image is 0 x 0'),
        (np.zeros((240, 320, 3), np.float32), 'and type float32, expected'),
    ],
    ids=['size', 'grey', 'empty', 'type'],
)
def test_bad_image_is_refused_with_its_shape(mapping, image, reason):
    with pytest.raises(ValueError, match=reason):
        EventTracker(EventTrackerConfig(), mapping).step(image, 1, None)


@pytest.mark.parametrize('back_ns', [0, 1, 900_000_000])
def test_repeated_or_backward_stamp_is_refused_and_changes_nothing(stage, back_ns):
    stage.show([])
    last = stage.index * 40_000_000
    with pytest.raises(BackwardStampError, match='not later'):
        stage.pipeline.step(stage.image([]), last - back_ns, None)
    stage.show([])


def test_a_given_background_outlives_a_far_step_back(new_stage, mapping):
    stage = new_stage()
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping, background=empty(mapping))
    stage.show([])
    stage.index = 0
    assert len(stage.show([((0.0, 0.0), WHITE)]).detections) == 1


def test_far_step_back_starts_over(stage):
    stage.index = 0
    assert not len(stage.show([((0.0, 0.0), WHITE)]).detections)


def test_mask_of_wrong_size_is_refused(mapping):
    with pytest.raises(ValueError, match='mask has shape'):
        EventTracker(EventTrackerConfig(), mapping, np.zeros((3, 3), np.uint8))


def test_masked_part_is_ignored(mapping, new_stage):
    stage = new_stage()
    mask = np.zeros((240, 320), np.uint8)
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping, mask)
    stage.empty()
    assert not len(stage.show([((0.0, 0.0), RED)]).detections)


@pytest.mark.parametrize('seed', range(4))
def test_camera_that_sees_the_horizon_publishes_only_what_is_on_the_ground(seed):
    intrinsics = np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]])
    level = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])  # looks along y, 1.7 m up
    eye = np.array([0.0, 0.0, 1.7])
    mapping = ProjectiveMapping(intrinsics @ np.column_stack([level, -level @ eye]), (320, 240))
    pipeline, rng, found = (
        EventTracker(EventTrackerConfig(), mapping),
        np.random.default_rng(seed),
        0,
    )
    for index in range(80):
        image = np.full((240, 320, 3), (60, 120, 60), np.uint8)
        for _ in range(8 if index > 30 else 0):
            left, top = rng.integers(0, 300), rng.integers(40, 200)
            width, height = rng.integers(4, 60), rng.integers(4, 190)
            image[top : top + height, left : left + width] = rng.integers(0, 255, 3)
        detections = pipeline.step(image, (index + 1) * 40_000_000, None).detections
        found += len(detections)
        assert np.isfinite(detections.position).all()
        assert np.isfinite(detections.covariance).all()
    assert found


def test_a_camera_that_has_moved_is_less_certain_by_the_shift(mapping):
    size = mapping.image_size
    paving = cv2.resize(
        np.random.default_rng(3).integers(60, 160, (40, 50, 3)).astype(np.uint8),
        (size[0] + 40, size[1] + 40),
        interpolation=cv2.INTER_NEAREST,
    )

    paving[70:160, size[0] - 70 : size[0] - 10] = 100  # of one colour: it does not show the shift

    quick = CameraShiftConfig(settling_s=2.0, sustain_s=2.0)

    def walk(shift_px):
        pipeline = EventTracker(EventTrackerConfig(camera_shift=quick), mapping)
        for index in range(80):
            offset = 20 - (shift_px if index > 50 else 0)
            image = paving[20 : 20 + size[1], offset : offset + size[0]].copy()
            if index > 10:
                left = 60 + index
                image[60:130, left : left + 18] = RED
            stamp_ns = (index + 1) * 100_000_000
            output = pipeline.step(image, stamp_ns, None)
        return output

    still, moved = walk(0), walk(4)
    assert moved.shift.state is ShiftState.MOVED
    assert moved.shift.size_px == pytest.approx(4.0, abs=0.2)

    def pixel_variance(output):
        """Return the mean variance, px², of what is published of the walker."""
        x = 60 + 79 + 9
        box = output.detections.box
        walker = np.abs(box[:, 0] + box[:, 2] / 2 - x).argmin()
        jacobian = mapping.image_jacobian(output.detections.position[walker, None, :2])[0]
        covariance = jacobian @ output.detections.covariance[walker] @ jacobian.T
        return np.trace(covariance) / 2

    grown = pixel_variance(moved) - pixel_variance(still)
    assert grown == pytest.approx(moved.shift.size_px**2, rel=0.15)


def test_a_given_background_is_believed_for_a_second(new_stage, mapping):
    stage, background = new_stage(), empty(mapping)
    background[100:135, 153:163] = 250  # not there any more
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping, background=background)
    seen = [len(stage.show([]).detections) for _ in range(75)]
    assert all(seen[:25])
    assert not any(seen[50:])
