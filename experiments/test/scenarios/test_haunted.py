import numpy as np

from mctrack_experiments.scenarios.staged.haunted import (
    AT_A_TIME,
    SECOND_NS,
    TOLD_S,
    WINDOW_S,
    dead,
    haunted,
)
from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.simulation import Scenario
from mctrack_ros.simulation.recording import simulate

GHOSTS = [np.array([[10.0, 10.0], [50.0, 50.0]])]


def reported(seconds, place, status=TrackStatus.CONFIRMED):
    stamp_ns = round(seconds * SECOND_NS)
    return Tracks.build(stamp_ns, position=[[*place, 0.0]], track_id=[1], status=[status])


def test_a_ghost_that_is_reported_while_it_is_told_of_is_given_a_second():
    assert dead(GHOSTS, [reported(TOLD_S + 0.9, (10.5, 10.0))], 0) == [True, True]


def test_a_ghost_that_is_reported_later_lives():
    assert dead(GHOSTS, [reported(TOLD_S + 1.5, (10.5, 10.0))], 0) == [False, True]


def test_what_is_not_stood_for_and_other_windows_do_not_count():
    tentative = reported(TOLD_S + 1.5, (10.0, 10.0), TrackStatus.TENTATIVE)
    assert dead(GHOSTS, [tentative, reported(WINDOW_S + 3.5, (10.0, 10.0))], 0) == [True, True]


def test_cameras_that_are_told_of_ghosts_go_on(here, tmp_path):
    simulate(Scenario(duration_s=0.4), tmp_path / 'match')
    assert len(haunted(tmp_path / 'match', 1, 1)) == AT_A_TIME
