import cv2
import numpy as np
import pytest

from mctrack_ros.config import config_from
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from sensor_noise import with_noise

SIZE = (320, 240)
PERIOD_NS = 40_000_000


@pytest.fixture(scope='session')
def mapping():
    """Camera 6 m above the ground at (0, -12) that looks at the origin."""
    eye = np.array([0.0, -12.0, 6.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.array([1.0, 0, 0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]])
    return ProjectiveMapping(intrinsics @ np.column_stack([rotation, -rotation @ eye]), SIZE)


class Stage:
    """Draws upright people on a noisy ground and drives a pipeline with the images."""

    def __init__(self, mapping, config=None, seed=0):
        self.mapping = mapping
        self.config = config or EventTrackerConfig()
        self.pipeline = EventTracker(self.config, mapping)
        self.rng = np.random.default_rng(seed)
        self.index = 0

    def image(self, people):
        image = np.full((SIZE[1], SIZE[0], 3), (60, 120, 60), np.uint8)
        for (x, y), colour in sorted(people, key=lambda one: -one[0][1]):
            place = np.array([[x, y]], float)
            foot = self.mapping.image_from_ground(place)[0]
            height = self.mapping.height_px(place, 1.75)[0]
            width = self.mapping.width_px(place, 0.6)[0]
            low = (round(foot[0] - width / 2), round(foot[1] - height))
            high = (round(foot[0] + width / 2) - 1, round(foot[1]) - 1)
            centre = ((low[0] + high[0]) // 2, (low[1] + high[1]) // 2)
            axes = ((high[0] - low[0]) // 2, (high[1] - low[1]) // 2)
            cv2.ellipse(image, centre, axes, 0, 0, 360, colour, -1)
        return with_noise(image, 2, self.rng)

    def show(self, people, feedback=None):
        self.index += 1
        stamp_ns = self.index * PERIOD_NS
        if callable(feedback):
            feedback = feedback(stamp_ns)
        return self.pipeline.step(self.image(people), stamp_ns, feedback)

    def empty(self, seconds=1.2):
        for _ in range(int(seconds / (PERIOD_NS * 1e-9))):
            self.show([])


@pytest.fixture
def new_stage(mapping):
    def make(**config):
        stage = Stage(mapping, config_from(EventTrackerConfig, config))
        stage.empty()
        return stage

    return make


@pytest.fixture
def stage(mapping):
    stage = Stage(mapping)
    stage.empty()
    return stage
