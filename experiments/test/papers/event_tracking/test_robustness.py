import pytest

from mctrack_experiments.papers.event_tracking.robustness import detections_found, recovery_s
from mctrack_ros.interfaces import Detections, Tracks
from mctrack_ros.recording import BagWriter
from mctrack_ros.simulation import Scenario

CAMERAS = ('cam1', 'cam2', 'cam3', 'cam4', 'cam5')
SCENARIO = Scenario(duration_s=6.0, rate_hz=10.0, gain_step=0.3, step_s=3.0)
PEOPLE = [[x, 10.0, 0.0] for x in range(0, 40, 4)]
NOBODY = [[x, 30.0, 0.0] for x in range(0, 40, 4)]


def recorded(folder, found, false=lambda now: 0):
    """Write people who are all there, and how many are found, and found in vain, at each time."""
    with BagWriter(folder / 'truth') as truth, BagWriter(folder / 'tracked') as tracked:
        for step in range(SCENARIO.steps):
            stamp_ns = SCENARIO.stamp_ns(step)
            now = (step + 0.5) * SCENARIO.period_s
            truth.write_rows('/truth/tracks', Tracks.build(stamp_ns, position=PEOPLE), 'map')
            for camera in CAMERAS:
                everybody = Detections.build(stamp_ns, position=PEOPLE)
                truth.write_rows(f'/truth/{camera}/detections', everybody, 'map')
                place = PEOPLE[: found(now)] + NOBODY[: false(now)]
                seen = Detections.build(stamp_ns, position=place, member_count=[1] * len(place))
                tracked.write_rows(f'/{camera}/detections', seen, 'map')
    return detections_found(folder / 'truth', folder / 'tracked', SCENARIO)


@pytest.mark.parametrize('blind_s', [0.0, 0.5, 1.5])
def test_recovery_is_the_time_until_people_are_found_again(tmp_path, blind_s):
    found = recorded(tmp_path, lambda now: 2 if 3.0 <= now < 3.0 + blind_s else 10)
    assert recovery_s(found, 3.0) == pytest.approx(blind_s, abs=0.11)
    assert found.false_between(0.0, 6.0) == 0.0


def test_who_is_never_found_again_is_not_recovered(tmp_path):
    found = recorded(tmp_path, lambda now: 10 if now < 3.0 else 0)
    assert recovery_s(found, 3.0) == float('inf')


def test_what_is_not_there_keeps_a_camera_from_having_recovered(tmp_path):
    found = recorded(tmp_path, lambda now: 10, lambda now: 4 * (3.0 <= now < 4.0))
    assert recovery_s(found, 3.0) == pytest.approx(1.0, abs=0.11)
    assert found.false_between(3.0, 4.0) == pytest.approx(4.0)
    assert found.false_between(3.0, 5.0) == pytest.approx(2.0)
