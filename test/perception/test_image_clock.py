import numpy as np
import pytest

from mctrack_ros.perception.image_clock import BackwardStampError, ImageClock

SECOND_NS = 1_000_000_000


def jumps(seconds):
    """Return which of some stamps, s, are jumps."""
    clock, found = ImageClock(), []
    for stamp_s in seconds:
        clock.advance(round(stamp_s * SECOND_NS))
        found.append(clock.jumped)
    return found


@pytest.mark.parametrize('rate_hz', [0.2, 0.5, 0.9, 1.0, 4.0, 25.0])
def test_a_steady_camera_never_jumps_however_slow(rate_hz):
    rng = np.random.default_rng(2)
    stamps = 100 + (np.arange(60) + rng.uniform(-0.1, 0.1, 60)) / rate_hz
    assert not any(jumps(stamps)[2:])


def test_a_lost_image_of_a_slow_camera_is_no_jump():
    assert not any(jumps([0.0, 0.8, 1.6, 3.2, 4.0]))


@pytest.mark.parametrize('rate_hz', [4.0, 25.0])
def test_a_gap_of_more_than_a_second_is_one(rate_hz):
    before = np.arange(10) / rate_hz
    after = before + before[-1] + 1.01
    assert jumps([*before, *after]) == 10 * [False] + [True] + 9 * [False]


def test_a_camera_that_becomes_slow_jumps_once():
    assert jumps([0.0, 0.04, 0.08, 2.08, 4.08, 6.08]) == 3 * [False] + [True] + 2 * [False]


def test_a_far_step_back_is_a_jump_and_a_small_one_is_refused():
    clock = ImageClock()
    for stamp_ns in (10 * SECOND_NS, 10 * SECOND_NS + 40):
        clock.advance(stamp_ns)
    for stamp_ns in (10 * SECOND_NS + 40, 9 * SECOND_NS + 40):
        with pytest.raises(BackwardStampError, match='not later'):
            clock.advance(stamp_ns)
    assert clock.seconds == 40e-9
    clock.advance(9 * SECOND_NS)
    assert (clock.jumped, clock.stepped_back, clock.seconds) == (True, True, 0.0)
    clock.advance(9 * SECOND_NS + 40)
    assert (clock.jumped, clock.stepped_back) == (False, False)
