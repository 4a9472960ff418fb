from functools import partial
from types import SimpleNamespace

import pytest

from mctrack_experiments.papers.event_tracking import robustness
from mctrack_experiments.papers.event_tracking.robustness import detections_found, recovery_s
from mctrack_ros.interfaces import Detections, Tracks
from mctrack_ros.recording import BagWriter
from mctrack_ros.simulation import Scenario

CAMERAS = ('cam1', 'cam2', 'cam3', 'cam4', 'cam5')
SCENARIO = Scenario(duration_s=6.0, rate_hz=10.0, gain_step=0.3, step_s=3.0)
PEOPLE = [[x, 10.0, 0.0] for x in range(0, 40, 4)]
NOBODY = [[x, 30.0, 0.0] for x in range(0, 40, 4)]


def recorded(folder, found, false=lambda now: 0):
    """Return what is told of people who are all there, so many found, and found in vain."""
    written(folder, SCENARIO, found, false)
    return detections_found(folder / 'truth', folder / 'tracked', SCENARIO)


def written(folder, scenario, found, false):
    with BagWriter(folder / 'truth') as truth, BagWriter(folder / 'tracked') as tracked:
        for step in range(scenario.steps):
            stamp_ns = scenario.stamp_ns(step)
            now = (step + 0.5) * scenario.period_s
            truth.write_rows('/truth/tracks', Tracks.build(stamp_ns, position=PEOPLE), 'map')
            for camera in CAMERAS:
                everybody = Detections.build(stamp_ns, position=PEOPLE)
                truth.write_rows(f'/truth/{camera}/detections', everybody, 'map')
                place = PEOPLE[: found(now)] + NOBODY[: false(now)]
                seen = Detections.build(stamp_ns, position=place, member_count=[1] * len(place))
                tracked.write_rows(f'/{camera}/detections', seen, 'map')


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


def test_every_disturbance_has_its_false_detections(tmp_path, monkeypatch):
    """Brighter light makes three people in every image until a second after the step."""

    def tracked(scenario, folder):
        name = 'bright' if scenario.light_step > 0 else 'plain'
        if not (tmp_path / name).exists():
            most = 3 if name == 'bright' else 0
            span = robustness.STEP_S, robustness.STEP_S + 1.0
            false = lambda now: most * (span[0] <= now < span[1])  # noqa: E731
            written(tmp_path / name, scenario, lambda now: 10, false)
        return tmp_path / name / 'truth', tmp_path / name / 'tracked'

    monkeypatch.setattr(robustness, 'Scenario', partial(Scenario, rate_hz=5.0))
    monkeypatch.setattr(robustness, '_tracked', tracked)
    scores = SimpleNamespace(figures={'mota': 0.9})
    monkeypatch.setattr(robustness, 'compare', lambda *arguments: scores)
    figures = robustness.reproduce_robustness((1001,), 15.0).figures
    assert figures['brighter.false'] == pytest.approx(1.5, abs=0.1)
    assert figures['brighter.recovery_max_s'] == pytest.approx(1.0, abs=0.2)
    for name in set(robustness.DISTURBANCES) - {'brighter'}:
        assert figures[f'{name}.false'] == 0.0
    assert figures['darker.recovery_max_s'] == 0.0
