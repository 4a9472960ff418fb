"""What a camera makes of images that show nothing; docs/reference/images.md states the same."""

import numpy as np
import pytest

from mctrack_ros.perception import CAMERA, Given, open_camera

RED, BLUE, WHITE = (30, 30, 220), (220, 60, 30), (240, 240, 240)
SHAPE = (240, 320, 3)


def walking(stage):
    """Show two people one step further on."""
    x = 0.03 * (stage.index % 100)
    return stage.show([((-3 + x, 0.0), RED), ((x, 1.5), BLUE)])


def shown(stage, image):
    stage.index += 1
    return stage.pipeline.step(image, stage.index * 40_000_000, None)


@pytest.fixture
def walked(stage):
    """Two people who are tracked."""
    for _ in range(25):
        output = walking(stage)
    assert len(output.detections) == 2
    return stage


@pytest.mark.parametrize('level', [0, 255])
@pytest.mark.parametrize('count', [1, 50])
def test_black_or_white_images_count_as_none(walked, level, count):
    known = set(walking(walked).detections.local_id.tolist())
    for _ in range(count):
        output = shown(walked, np.full(SHAPE, level, np.uint8))
        assert not len(output.detections)
        assert output.messages['detections'].is_blind
    for _ in range(10):
        output = walking(walked)
    assert len(output.detections) == 2
    is_short = count * 0.04 < 1
    assert (set(output.detections.local_id.tolist()) == known) == is_short


def test_all_noise_is_nobody_and_a_second_later_all_is_well(walked):
    rng = np.random.default_rng(5)
    for _ in range(75):
        noise = rng.integers(0, 256, SHAPE).astype(np.uint8)
        assert len(shown(walked, noise).detections) <= 1
    for _ in range(30):
        assert not len(walked.show([]).detections)
    for _ in range(10):
        output = walked.show([((0.0, 0.0), WHITE)])
    assert len(output.detections) == 1


def test_a_frozen_image_shows_whom_it_shows_and_no_more(walked):
    frozen = walked.image([((0.0, 0.0), RED), ((2.0, 1.5), BLUE)])
    counts = [len(shown(walked, frozen).detections) for _ in range(150)]
    assert max(counts) <= 4
    assert max(counts[50:]) <= 2
    for _ in range(30):
        walked.show([])
    assert not len(walked.show([]).detections)


def test_another_size_is_refused_and_the_next_image_is_as_ever(walked):
    with pytest.raises(ValueError, match='image is 640 x 480'):
        shown(walked, np.zeros((480, 640, 3), np.uint8))
    assert len(walking(walked).detections) == 2


@pytest.mark.parametrize('gap_s', [0.9, 5.0, 3600.0])
def test_whoever_stands_after_a_gap_is_not_taken_for_background(new_stage, gap_s):
    stage = new_stage()
    for _ in range(25):
        walking(stage)
    stage.index += round(25 * gap_s)
    seen = [len(stage.show([((0.0, 0.0), RED)]).detections) for _ in range(50)]
    assert sum(count == 1 for count in seen) > 45


@pytest.mark.parametrize('images', [25, 60])
def test_a_dropped_second_costs_at_most_ids(walked, images):
    walked.index += images
    for _ in range(10):
        output = walking(walked)
        assert len(output.detections) <= 4
    assert len(output.detections) == 2


@pytest.mark.parametrize('jump_s', [3600, -30])
def test_a_clock_that_jumps_begins_anew(walked, jump_s):
    walked.index += 25 * jump_s if jump_s > 0 else -walked.index
    counts = [len(walked.show([((0.0, 0.0), WHITE)]).detections) for _ in range(5)]
    assert max(counts) <= 3
    for _ in range(30):
        walked.show([])
    assert not len(walked.show([]).detections)


@pytest.mark.parametrize('level', [0, 255])
def test_the_silhouettes_tracker_takes_black_and_white_for_none_too(mapping, new_stage, level):
    stage = new_stage()
    stage.pipeline = open_camera(CAMERA.made('silhouettes'), Given('cam1', mapping))
    stage.empty()
    for step in range(30):
        stage.show([((0.05 * step, 0.0), WHITE)])
    before = stage.pipeline.objects.local_id.tolist()
    assert len(before) == 1
    assert not len(shown(stage, np.full(SHAPE, level, np.uint8)).detections)
    stage.show([((1.5, 0.0), WHITE)])
    assert stage.pipeline.objects.local_id.tolist() == before


@pytest.mark.parametrize('tracker', ['event_tracker', 'silhouettes'])
@pytest.mark.parametrize(('black', 'after'), [(range(20, 100), 100), (range(91, 200), 85)])
def test_a_clip_that_begins_again_with_black_images_is_tracked_again(
    mapping, new_stage, tracker, black, after
):
    stage = new_stage()
    stage.pipeline = open_camera(CAMERA.made(tracker), Given('cam1', mapping))
    for _ in range(60):
        walking(stage)
    for index in black:
        stage.pipeline.step(np.zeros(SHAPE, np.uint8), index * 40_000_000, None)
    stage.index = after
    stage.empty()
    seen = max(len(walking(stage).detections) for _ in range(100))
    assert seen == 2
