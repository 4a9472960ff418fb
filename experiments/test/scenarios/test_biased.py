"""The scenes in which a camera is wrong for a while."""

import numpy as np
import pytest

from mctrack_experiments.scenarios.biased import (
    BEGINS_S,
    ENDS_S,
    SECONDS,
    TICK_S,
    Fault,
    spoiled,
    times,
)
from mctrack_ros.interfaces import CameraDetections, Detections

TICKS = round(SECONDS / TICK_S)
PLACES = np.array([[10.0, 0.0, 0.0], [0.0, 5.0, 0.0]])


def told(fault, camera=(0.0, 0.0), heading=0.0):
    rows = Detections.build(0, position=PLACES, covariance=np.tile(np.eye(2), (2, 1, 1)))
    message = spoiled(CameraDetections('cam1', rows), fault, np.array(camera), heading)
    return message.rows.position


def test_an_honest_camera_tells_what_it_sees():
    assert np.allclose(told(Fault()), PLACES)


def test_a_fault_displaces_or_turns_about_the_camera():
    assert np.allclose(told(Fault(2.0), heading=np.pi / 2), PLACES + np.array([0, 2, 0]))
    assert np.allclose(told(Fault(turn_deg=90.0))[:, :2], [[0, 10], [-5, 0]], atol=1e-5)
    assert np.allclose(told(Fault(turn_deg=180.0), (10.0, 0.0))[0], PLACES[0], atol=1e-5)


def test_times_are_those_from_the_fault_and_from_its_end():
    doubted = np.zeros((TICKS, 3), bool)
    begins, ends = round(BEGINS_S / TICK_S), round(ENDS_S / TICK_S)
    doubted[begins + 100 : ends + 50, 1] = True
    found = times(doubted, 1, True)
    assert found == pytest.approx({'blamed': 0.0, 'found_s': 4.0, 'mended_s': 2.0})
    assert times(doubted, 0, False)['blamed'] > 0
    assert np.isnan(times(doubted, 0, True)['found_s'])
