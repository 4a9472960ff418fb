import numpy as np
import pytest

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception import EventTracker, EventTrackerConfig

RED, BLUE, GREEN = (40, 40, 200), (200, 60, 40), (90, 200, 90)
NEAR, BESIDE, BEHIND = (-0.3, 0.0), (0.3, 0.0), (0.0, 1.2)


@pytest.fixture
def camera(new_stage, mapping):
    stage = new_stage()
    background = np.full((*mapping.image_size[::-1], 3), (60, 120, 60), np.uint8)
    stage.pipeline = EventTracker(EventTrackerConfig(), mapping, background=background)
    return stage


def reported(*places, variance=0.02):
    """Feedback of targets 1, 2, ... who stand at some places."""

    def feedback(stamp_ns):
        return Feedback.build(
            stamp_ns - 80_000_000,
            position=[[*place, 0.0] for place in places],
            covariance=[np.eye(4) * variance] * len(places),
            track_id=np.arange(1, len(places) + 1),
        )

    return feedback


def people(*places):
    return [*zip(places, (RED, BLUE, GREEN))]


def tracked(camera):
    return camera.pipeline._tracker.tracks.track_id.tolist()


def test_who_is_expected_in_a_group_is_looked_for_there(camera):
    for _ in range(12):
        camera.show(people(NEAR, BESIDE, BEHIND), reported(NEAR, BESIDE, BEHIND))
    assert sorted(tracked(camera)) == [1, 2, 3]


@pytest.mark.parametrize(
    'variance',
    [
        0.005,
        pytest.param(
            0.02,
            marks=pytest.mark.xfail(strict=True, reason='he is taken for what two bodies leave'),
        ),
    ],
)
def test_of_whom_nothing_is_seen_nothing_is_told(camera, variance):
    for _ in range(12):
        told = reported(NEAR, BESIDE, (0.3, 0.1), variance=variance)
        output = camera.show(people(NEAR, BESIDE), told)
    assert 3 not in output.detections.track_id.tolist()


def test_behind_one_person_nobody_is_looked_for(camera):
    for _ in range(12):
        camera.show(people(NEAR), reported(NEAR, (-0.3, 0.8)))
    assert tracked(camera) == [1]
