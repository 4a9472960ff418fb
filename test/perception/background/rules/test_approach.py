import numpy as np

from mctrack_ros.perception.background.rules.approximate_median import approach


def test_every_pixel_moves_one_grey_level_to_the_image_or_stays():
    rng = np.random.default_rng(0)
    model = rng.choice(np.array([0, 1, 7, 8, 9, 254, 255], np.uint8), (9, 11, 3))
    image = rng.choice(np.array([0, 8, 255], np.uint8), (9, 11, 3))
    kept = rng.choice(np.array([0, 255], np.uint8), (9, 11))
    step = np.sign(image.astype(int) - model) * (kept == 0)[..., None]
    expected = model + step
    approach(model, image, kept)
    assert np.array_equal(model, expected)
