import cv2
import numpy as np
import pytest

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception.silhouettes import SilhouettePipeline
from sensor_noise import with_noise

SIZE = (640, 480)
PERIOD_NS = 250_000_000


@pytest.fixture(scope='session')
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

    def __init__(self, config, mapping, noise=2.0):
        self.rng, self.noise = np.random.default_rng(0), noise
        self.ground = cv2.GaussianBlur(self.rng.normal(110, 60, SIZE[::-1]), (0, 0), 3)
        self.index = 0
        self.pipeline = SilhouettePipeline(config, mapping, background=self.image([]))
        self.show([])

    def image(self, things):
        drawn = self.ground.copy()
        for x, bottom, (width, height), grey in things:
            low, high = max(round(x - width / 2), 0), max(round(x + width / 2), 0)
            drawn[round(bottom) - height : round(bottom), low:high] = grey
        return cv2.cvtColor(with_noise(drawn, self.noise, self.rng), cv2.COLOR_GRAY2BGR)

    def show(self, things):
        return self.step(self.image(things))

    def step(self, image):
        self.index += 1
        return self.pipeline.step(image, self.index * PERIOD_NS, None)


@pytest.fixture
def new_park(mapping):
    return lambda config, **options: CarPark(config, mapping, **options)
