import cv2
import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception import BackwardStampError, CameraConfig, open_camera
from mctrack_ros.perception.silhouettes import SilhouetteConfig, SilhouettePipeline, as_printed

SIZE = (640, 480)
PERIOD_NS = 250_000_000
PERSON, CAR = (20, 62), (150, 70)
VERSIONS = pytest.mark.parametrize(
    'config', [SilhouetteConfig(), as_printed()], ids=['ours', 'printed']
)


@pytest.fixture(scope='module')
def mapping():
    """Camera 9 m above the ground that looks at the ground 20 m away."""
    eye = np.array([0.0, -20.0, 9.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.array([1.0, 0, 0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
    return ProjectiveMapping(intrinsics @ np.column_stack([rotation, -rotation @ eye]), SIZE)


class CarPark:
    """Draws grey rectangles on a noisy ground and drives a pipeline at 4 Hz."""

    def __init__(self, config, mapping):
        self.pipeline = SilhouettePipeline(config, mapping)
        self.rng = np.random.default_rng(0)
        ground = self.rng.normal(110, 60, SIZE[::-1])
        self.ground = cv2.GaussianBlur(ground, (0, 0), 3)
        self.index = 0
        self.show([])

    def picture(self, things):
        drawn = self.ground.copy()
        for x, bottom, (width, height), grey in things:
            low, high = max(round(x - width / 2), 0), max(round(x + width / 2), 0)
            drawn[round(bottom) - height : round(bottom), low:high] = grey
        noisy = np.clip(drawn + self.rng.normal(0, 2, drawn.shape), 0, 255).astype(np.uint8)
        return cv2.cvtColor(noisy, cv2.COLOR_GRAY2BGR)

    def show(self, things):
        self.index += 1
        return self.pipeline.step(self.picture(things), self.index * PERIOD_NS, None)


@pytest.fixture
def new_park(mapping):
    return lambda config: CarPark(config, mapping)


@VERSIONS
def test_a_pedestrian_keeps_one_id_and_is_passed_on_after_three_seconds(new_park, config):
    park, ids, passed = new_park(config), set(), []
    for step in range(20):
        output = park.show([(100 + 6 * step, 380, PERSON, 60)])
        ids |= set(output.detections.local_id.tolist())
        passed.append(park.pipeline.objects.passed_on.any())
    assert len(ids) == 1
    assert passed.index(True) == 12
    assert output.detections.class_id.tolist() == [ClassCode.PERSON]


@VERSIONS
def test_a_vehicle_is_known_as_one_and_never_passed_on(new_park, config):
    park = new_park(config)
    for step in range(20):
        output = park.show([(100 + 15 * step, 300, CAR, 160)])
    assert output.detections.class_id.tolist() == [ClassCode.VEHICLE]
    assert not park.pipeline.objects.passed_on.any()


def test_the_site_chooses_the_tracker(mapping):
    config = CameraConfig(local_tracker='silhouettes')
    assert isinstance(open_camera(config, mapping), SilhouettePipeline)


def test_a_stamp_that_comes_again_is_refused(new_park):
    park = new_park(SilhouetteConfig())
    with pytest.raises(BackwardStampError):
        park.pipeline.step(park.picture([]), park.index * PERIOD_NS, None)
