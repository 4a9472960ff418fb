import numpy as np

from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.background.noise import MEDIAN_OF_LARGEST, NoiseMap

SECOND = 1_000_000_000
SHAPE = (96, 128, 3)


def noisy(rng, sigma):
    """Return a grey image with a noise per pixel."""
    return np.clip(np.rint(rng.normal(120, 1, SHAPE) + rng.normal(0, sigma)), 0, 255).astype(
        np.uint8
    )


def sigma_of(left, right):
    sigma = np.full(SHAPE, float(left))
    sigma[:, SHAPE[1] // 2 :] = right
    return sigma


def watched(sigma, seconds=10.0, rate=10, person=None):
    """Return the mask of the last image."""
    rng = np.random.default_rng(3)
    background = Background(BackgroundConfig())
    for index in range(int(seconds * rate)):
        image = noisy(rng, sigma)
        if person is not None and index == int(seconds * rate) - 1:
            top, left, grey = person
            image[top : top + 24, left : left + 8] = grey
        mask = background.apply(image, (index + 1) * SECOND // rate)
        if mask is not None:
            none = np.zeros_like(mask)
            background.learn(image, mask, none, none, (index + 1) * SECOND // rate)
    return mask


def test_a_noisy_half_makes_no_foreground_and_does_not_blind_the_other():
    mask = watched(sigma_of(1, 10), person=(30, 20, 120 + 25))
    assert (mask[:, 72:] > 0).mean() < 0.01
    assert (mask[32:52, 21:27] > 0).mean() > 0.95


def test_where_noise_is_the_same_everywhere_so_is_the_threshold():
    rng = np.random.default_rng(5)
    learned = NoiseMap()
    for _ in range(50):
        noise = np.abs(np.rint(rng.normal(0, 2, SHAPE)))
        difference = noise.max(axis=2).astype(np.uint8)
        learned.learn(difference, np.zeros_like(difference), 2.0, 0.2)
    assert np.abs(learned.ratio - 1).max() < 0.1


def test_foreground_tells_nothing_of_the_noise():
    difference = np.full(SHAPE[:2], 2, np.uint8)
    mask = np.zeros_like(difference)
    difference[:48, :64], mask[:48, :64] = 90, 255
    learned = NoiseMap()
    learned.learn(difference, mask, 2.0 / MEDIAN_OF_LARGEST, 0.2)
    np.testing.assert_allclose(learned.ratio, 1.0)


def test_a_bound_that_rises_counts_at_once():
    difference, mask = np.full(SHAPE[:2], 20, np.uint8), np.zeros(SHAPE[:2], np.uint8)
    learned = NoiseMap()
    learned.foreground(difference, 12.0, 10.0, mask)
    assert mask.all()
    learned.foreground(difference, 25.0, 10.0, mask)
    assert not mask.any()
    learned.foreground(difference, 12.0, 30.0, mask)
    assert not mask.any()
