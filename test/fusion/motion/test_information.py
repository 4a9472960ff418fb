"""The information filter against plain matrices."""

import numpy as np
import pytest

from mctrack_ros.fusion.measurements.packed import measured
from mctrack_ros.fusion.motion.information import INFORMATION_SIZE, gathered, updated


def spreads(rng, *shape):
    """Return random covariances whose components depend on one another."""
    root = rng.normal(0, 0.5, (*shape, shape[-1]))
    return root @ root.swapaxes(-1, -2) + 0.05 * np.eye(shape[-1])


@pytest.mark.parametrize('seed', range(6))
def test_what_images_tell_updates_as_the_information_filter_does(seed):
    """Pairs of every image, some in doubt, some for nothing; one track that nobody tells of."""
    rng = np.random.default_rng(seed)
    mean, covariance = rng.normal(0, 3, (5, 4)), spreads(rng, 5, 4)
    position, noise = rng.normal(0, 3, (9, 2)), spreads(rng, 9, 2)
    seconds = rng.uniform(-0.5, 0.0, 3)
    pairs = sorted(
        (image, int(track), 3 * image + row)
        for image in range(3)
        for row in range(3)
        for track in rng.choice(4, 2, replace=False)
    )
    image, track, detection = np.array(pairs).T.copy()
    share = rng.choice([0.0, 0.3, 1.0], len(pairs))
    share[track == 3] = 0.0
    seen = measured(position, noise, np.arange(9))
    told = gathered(mean, seconds, image, track, detection, share, seen)
    assert told.shape == (5, INFORMATION_SIZE)
    found_mean, found_covariance = updated(mean, covariance, told)
    for own in range(5):
        information = np.linalg.inv(covariance[own])
        pull = information @ mean[own]
        for of_image, of_track, row in pairs:
            if of_track == own:
                matrix = np.hstack([np.eye(2), seconds[of_image] * np.eye(2)])
                weight = share[pairs.index((of_image, of_track, row))] * matrix.T
                weight = weight @ np.linalg.inv(noise[row])
                information = information + weight @ matrix
                pull = pull + weight @ position[row]
        np.testing.assert_allclose(found_covariance[own], np.linalg.inv(information), atol=1e-9)
        np.testing.assert_allclose(found_mean[own], np.linalg.solve(information, pull), atol=1e-9)
    np.testing.assert_array_equal(found_mean[3:], mean[3:])
    np.testing.assert_array_equal(found_covariance[3:], covariance[3:])
