import copy

import cv2
import numpy as np
import pytest

from mctrack_ros.perception import ShiftState
from mctrack_ros.perception.camera_shift.monitor import (
    UNKNOWN_PX,
    CameraShiftConfig,
    CameraShiftMonitor,
)
from moving_camera import SIZE, ground, seen

PERIOD_S = 0.4
SETTLED_S = 10.0


class Camera:
    """A camera in front of a textured ground, and what watches it."""

    def __init__(self, allowed=None, seed=0):
        self.still = ground(seed)
        self.monitor = CameraShiftMonitor(CameraShiftConfig(settling_s=5.0), allowed)
        self.rng = np.random.default_rng(seed)
        noise = self.rng.normal(0, 2, (2 * SIZE[1], SIZE[0], 3))
        self.noise = np.rint(noise).astype(np.int16)
        self.time_s = 0.0

    def show(self, seconds, change=lambda image, time_s: image, **moved):
        """Show the ground, moved and changed, for some time; return all that was said."""
        said = []
        for _ in range(round(seconds / PERIOD_S)):
            self.time_s += PERIOD_S
            image = change(seen(self.still, **moved), self.time_s)
            row = self.rng.integers(SIZE[1])
            noisy = np.clip(image + self.noise[row : row + SIZE[1]], 0, 255)
            said.append(self.monitor.watch(noisy.astype(np.uint8), round(self.time_s * 1e9)))
        return said


@pytest.fixture(scope='module')
def settled():
    camera = Camera()
    assert camera.show(SETTLED_S)[-1].state is ShiftState.STILL
    return camera


@pytest.fixture
def camera(settled):
    return copy.deepcopy(settled)


@pytest.mark.parametrize(
    ('moved', 'size_px'),
    [
        ({'right': 2.0}, 2.0),
        ({'down': -2.0}, 2.0),
        ({'right': -3.0, 'down': 4.0}, 5.0),
        ({'right': 12.0, 'down': 16.0}, 20.0),
        ({'right': -60.0, 'down': 5.0}, 60.2),
        ({'turn_deg': 1.0}, np.radians(1.0) * np.hypot(*SIZE) / np.sqrt(12)),
        ({'turn_deg': -1.0, 'right': 20.0}, 20.2),
    ],
    ids=str,
)
def test_a_moved_camera_is_found_in_time_with_the_size_of_its_shift(camera, moved, size_px):
    shift = camera.show(5.0, **moved)[-1]
    assert shift.state is ShiftState.MOVED
    assert shift.size_px == pytest.approx(size_px, abs=0.2)
    assert shift.noise_px == shift.size_px
    assert shift.right_px == pytest.approx(moved.get('right', 0.0), abs=0.2)
    assert shift.down_px == pytest.approx(moved.get('down', 0.0), abs=0.2)
    assert shift.turn_deg == pytest.approx(moved.get('turn_deg', 0.0), abs=0.03)


def test_the_alarm_ends_when_the_image_moves_back(camera):
    assert camera.show(5.0, right=5.0)[-1].state is ShiftState.MOVED
    shift = camera.show(5.0, right=0.3)[-1]
    assert shift.state is ShiftState.STILL
    assert shift.noise_px == 0.0


def test_the_alarm_lasts_while_half_the_threshold_is_exceeded(camera):
    camera.show(5.0, right=3.0)
    assert camera.show(6.0, right=1.0)[-1].state is ShiftState.MOVED


def test_a_knock_that_does_not_last_is_no_alarm(camera):
    said = camera.show(1.2, right=15.0) + camera.show(6.0)
    assert all(shift.state is ShiftState.STILL for shift in said)


def test_wind_is_no_alarm(camera):
    for right, down in camera.rng.normal(0, 0.5, (150, 2)):
        assert camera.show(PERIOD_S, right=right, down=down)[0].state is ShiftState.STILL


def test_light_that_drifts_is_no_alarm(camera):
    def lit(image, time_s):
        shade = 0.8 + 0.2 * np.sin(time_s / 5 + np.linspace(0, 6, SIZE[0]))
        return image * (shade * (1 + 0.2 * np.sin(time_s / 7)))[None, :, None]

    said = camera.show(60.0, lit)
    assert all(shift.state is ShiftState.STILL for shift in said)
    assert max(shift.size_px for shift in said) < 0.3


def crowd(image, time_s, count=40):
    image = image.copy()
    for person in range(count):
        x = (person * 97 + (20 + person) * time_s) % (SIZE[0] + 80) - 40
        foot = (round(x), 80 + person * 280 // count)
        cv2.ellipse(image, foot, (14, 40), 0, 0, 360, (person * 6, 200 - person * 4, 90), -1)
    return image


def test_a_passing_crowd_is_no_alarm(camera):
    assert all(shift.state is ShiftState.STILL for shift in camera.show(40.0, crowd))


def test_a_shift_is_found_behind_a_crowd(camera):
    assert camera.show(5.0, crowd, right=2.0)[-1].state is ShiftState.MOVED


def test_who_was_there_at_the_start_does_not_matter():
    camera = Camera()
    camera.show(40.0, crowd)
    assert camera.show(8.0)[-1].size_px < 0.3
    assert camera.show(5.0, down=2.0)[-1].state is ShiftState.MOVED


def test_a_crowd_that_hides_nearly_all_of_the_first_image_does_not_matter():
    camera = Camera()
    camera.show(PERIOD_S, lambda image, time_s: crowd(image, time_s, 400))
    assert camera.show(SETTLED_S)[-1].state is ShiftState.STILL
    assert camera.show(5.0, right=2.0)[-1].state is ShiftState.MOVED


def test_a_camera_that_is_shaken_at_first_is_learnt_once_it_stands_still():
    camera = Camera()
    for right, down in camera.rng.normal(0, 20, (20, 2)):
        camera.show(PERIOD_S, right=right, down=down)
    said = camera.show(3 * SETTLED_S, right=4.0)
    assert ShiftState.MOVED not in {shift.state for shift in said}
    assert said[-1].state is ShiftState.STILL
    assert camera.show(5.0, right=6.0)[-1].state is ShiftState.MOVED


def test_a_camera_that_is_dark_at_first_is_learnt_once_it_sees():
    camera = Camera()
    camera.show(SETTLED_S, lambda image, time_s: np.zeros_like(image))
    assert camera.show(3 * SETTLED_S)[-1].state is ShiftState.STILL
    assert camera.show(5.0, right=2.0)[-1].state is ShiftState.MOVED


def test_a_creeping_shift_adds_up_while_patches_are_exchanged(camera):
    for step in range(50):
        top, left = (camera.rng.integers(80, side) for side in SIZE[::-1])
        camera.still[top : top + 60, left : left + 60] = ground(step)[:60, :60]
        shift = camera.show(1.6, right=0.05 * step)[-1]
    assert shift.state is ShiftState.MOVED
    assert shift.right_px == pytest.approx(2.4, abs=0.3)


def test_a_covered_lens_is_said_and_no_shift(camera):
    said = camera.show(10.0, lambda image, time_s: np.zeros_like(image))
    assert said[-1].state is ShiftState.UNKNOWN
    assert said[-1].size_px == 0.0
    assert said[-1].noise_px == UNKNOWN_PX
    back = camera.show(6.0)[-1]
    assert back.state is ShiftState.STILL
    assert back.noise_px == 0.0


@pytest.mark.parametrize('moved', [{'right': 20.0}, {'turn_deg': 1.0}], ids=str)
def test_a_camera_that_moved_while_it_was_covered_is_found_in_time(camera, moved):
    cover = ground(seed=5)[: SIZE[1], : SIZE[0]]
    assert camera.show(60.0, lambda *_: cover)[-1].state is ShiftState.UNKNOWN
    assert camera.show(5.0, **moved)[-1].state is ShiftState.MOVED


def test_an_image_without_texture_is_never_judged():
    said = Camera().show(20.0, lambda image, time_s: np.full_like(image, 90))
    assert {shift.state for shift in said} == {ShiftState.SETTLING}


def test_what_is_ignored_does_not_vote():
    logo = ground(seed=9)[: SIZE[1] // 2 + 60, : SIZE[0]]

    def burnt_in(image, time_s):
        image = image.copy()
        image[: len(logo)] = logo
        return image

    allowed = np.full(SIZE[::-1], 255, np.uint8)
    allowed[: len(logo)] = 0
    camera = Camera(allowed)
    camera.show(SETTLED_S, burnt_in)
    assert camera.show(5.0, burnt_in, right=2.0)[-1].state is ShiftState.MOVED


def test_a_clock_that_steps_back_keeps_the_reference(camera):
    camera.time_s -= 9.0
    assert camera.show(5.0, right=5.0)[-1].state is ShiftState.MOVED


def test_the_same_images_give_the_same_answers():
    first, second = (Camera().show(12.0, crowd, right=1.0) for _ in range(2))
    assert first == second


def test_images_between_looks_cost_nothing_and_change_nothing(camera):
    before = camera.monitor.shift
    stamp_ns = round(camera.time_s * 1e9) + 1
    assert camera.monitor.watch(np.zeros((*SIZE[::-1], 3), np.uint8), stamp_ns) is before
