from itertools import islice

import numpy as np
import pytest

from mctrack_experiments.bench.perception.camera_shift import bench_camera_shift
from mctrack_experiments.real.camera_shift import (
    detection_delay,
    pitch_images,
    real_clips,
    scene_images,
    watch,
)
from mctrack_experiments.real.watched_scene import KINDS, WIND_PX, WatchedScene


@pytest.mark.parametrize('name', ['2px', '5px', '20px', 'turn'])
def test_a_movement_is_found_within_five_seconds(name):
    delay_s, _ = detection_delay(KINDS[1], name, 401)
    assert delay_s <= 5.0


@pytest.mark.parametrize('kind', KINDS)
def test_wind_light_and_crowds_are_no_alarm(kind):
    alarms, largest, judged = watch(scene_images(kind, 402, 40.0))
    assert alarms == 0
    assert largest < 1.4
    assert judged > 0.6


def test_the_pitch_in_changing_light_is_no_alarm():
    alarms, largest, _ = watch(islice(pitch_images(402), 80))
    assert alarms == 0
    assert largest < 0.2


def test_a_scene_is_drawn_again_the_same():
    first, second = (WatchedScene('square', 3, 10.0) for _ in range(2))
    assert np.array_equal(first.image(4.0), second.image(4.0))


def test_the_wind_is_as_strong_as_stated():
    wind = WatchedScene('square', 3, 600.0).wind
    assert np.sqrt((wind**2).mean()) == pytest.approx(WIND_PX)


def test_the_bench_compares_with_its_peer():
    figures = bench_camera_shift(10).figures
    assert figures['ms_per_image'] > 0
    assert figures['square.peer.phase_correlation.ms_per_image'] > 0


@pytest.mark.real_data
@pytest.mark.parametrize('clip', ['pets', 'terrace_c0', 'terrace_c1'])
def test_real_cameras_that_stand_still_give_no_alarm(data_root, clip):
    source, allowed = real_clips(data_root)[clip]
    alarms, largest, judged = watch(islice(source, 2000), allowed)
    assert alarms == 0
    assert largest < 0.5
    assert judged > 0.8
