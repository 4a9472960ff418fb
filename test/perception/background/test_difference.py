import numpy as np

from mctrack_ros.perception.background.difference import SAMPLED_PX, subtract


def test_difference_is_the_largest_of_the_channels():
    rng = np.random.default_rng(0)
    image, model = rng.integers(0, 256, (2, 40, 50, 3), np.uint8)
    difference = np.empty((40, 50), np.uint8)
    median = subtract(image, model, difference)
    assert np.array_equal(difference, np.abs(image.astype(int) - model).max(axis=2))
    sample = np.sort(difference[::SAMPLED_PX, ::SAMPLED_PX].ravel())
    assert median == sample[(len(sample) - 1) // 2]


def test_image_may_be_read_only():
    image = np.zeros((20, 20, 3), np.uint8)
    image.flags.writeable = False
    assert subtract(image, image, np.empty((20, 20), np.uint8)) == 0
