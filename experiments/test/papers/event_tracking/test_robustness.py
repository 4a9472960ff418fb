import pytest

from mctrack_experiments.papers.event_tracking.robustness import recovery_s
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagWriter
from mctrack_ros.simulation import Scenario

CAMERAS = ('cam1', 'cam2', 'cam3', 'cam4', 'cam5')
SCENARIO = Scenario(duration_s=6.0, rate_hz=10.0, gain_step=0.3, step_s=3.0)
PEOPLE = [[x, 10.0, 0.0] for x in range(0, 40, 4)]


def recorded(folder, found):
    """Write people who are all there, and how many of them are found at each time."""
    with BagWriter(folder / 'truth') as truth, BagWriter(folder / 'tracked') as tracked:
        for step in range(SCENARIO.steps):
            stamp_ns = SCENARIO.stamp_ns(step)
            count = found((step + 0.5) * SCENARIO.period_s)
            for camera in CAMERAS:
                everybody = Detections.build(stamp_ns, position=PEOPLE)
                truth.write_rows(f'/truth/{camera}/detections', everybody, 'map')
                seen = Detections.build(stamp_ns, position=PEOPLE[:count])
                tracked.write_rows(f'/{camera}/detections', seen, 'map')
    return recovery_s(folder / 'truth', folder / 'tracked', SCENARIO)


@pytest.mark.parametrize('blind_s', [0.0, 0.5, 1.5])
def test_recovery_is_the_time_until_people_are_found_again(tmp_path, blind_s):
    seconds = recorded(tmp_path, lambda now: 2 if 3.0 <= now < 3.0 + blind_s else 10)
    assert seconds == pytest.approx(blind_s, abs=0.11)


def test_who_is_never_found_again_is_not_recovered(tmp_path):
    assert recorded(tmp_path, lambda now: 10 if now < 3.0 else 0) == float('inf')
