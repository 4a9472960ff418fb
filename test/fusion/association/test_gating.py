import numpy as np
import pytest

from mctrack_ros.fusion.association.gating import distances, gated_pairs
from mctrack_ros.fusion.measurements.packed import measured

GATE = 13.8


def scene(rng, tracks, detections, images, width):
    """Return tracks, and detections some of which are very uncertain."""
    mean = np.column_stack(
        [rng.uniform(-width, width, (tracks, 2)), rng.normal(0, 3, (tracks, 2))]
    )
    spread = rng.normal(0, 0.3, (tracks, 4, 4))
    covariance = spread @ spread.swapaxes(1, 2) + 0.01 * np.eye(4)
    error = rng.normal(0, 0.4, (detections, 2, 2))
    noise = error @ error.swapaxes(1, 2) + 0.01 * np.eye(2)
    noise[rng.random(detections) < 0.1] *= 1000.0
    return (
        mean,
        covariance,
        rng.uniform(-0.04, 0.0, images),
        rng.uniform(-width, width, (detections, 2)),
        noise,
        np.sort(rng.integers(0, images, detections)),
    )


def gated(mean, covariance, seconds, position, noise, image):
    seen = measured(position, noise, np.arange(len(position)))
    return gated_pairs(mean, covariance, seconds, seen, image, GATE)


def every_pair(mean, covariance, seconds, position, noise, image):
    """Try all pairs: slow and obvious."""
    found = []
    for row, place in enumerate(position):
        matrix = np.hstack([np.eye(2), seconds[image[row]] * np.eye(2)])
        for track in range(len(mean)):
            gap = place - matrix @ mean[track]
            spread = matrix @ covariance[track] @ matrix.T + noise[row]
            if gap @ np.linalg.solve(spread, gap) < GATE:
                found.append((image[row], track, row))
    return sorted(found)


@pytest.mark.parametrize('seed', range(12))
def test_the_cells_find_what_trying_all_pairs_finds(seed):
    rng = np.random.default_rng(seed)
    given = scene(rng, rng.integers(1, 30), rng.integers(1, 60), 4, rng.choice([2, 10, 1000]))
    track, detection, image, slot = gated(*given)
    assert list(zip(image, track, detection)) == every_pair(*given)
    names = sorted(set(zip(image, track)))
    assert [names[number] for number in slot] == list(zip(image, track))


def test_who_is_fast_is_found_where_he_was():
    rng = np.random.default_rng(4)
    mean, _, _, position, _, image = scene(rng, 20, 60, 4, 50.0)
    seconds = np.array([-1.0, -0.5, -0.25, 0.0])
    mean[:, 2:] = rng.normal(0, 10, (20, 2))
    mean[:, :2] = position[:20] - seconds[image[:20], None] * mean[:, 2:]
    covariance, noise = np.zeros((20, 4, 4)), np.tile(0.04 * np.eye(2), (60, 1, 1))
    covariance[:, [0, 1], [0, 1]] = 0.04
    given = mean, covariance, seconds, position, noise, image
    track, detection, where, _ = gated(*given)
    assert list(zip(where, track, detection)) == every_pair(*given)
    assert len(track) >= 20


def test_distances_are_those_from_where_each_track_is_so_much_later():
    rng = np.random.default_rng(3)
    mean, covariance, _, position, noise, _ = scene(rng, 4, 6, 1, 5.0)
    seconds = rng.uniform(-1.0, 1.0, len(position))
    found = distances(mean, covariance, seconds, position, noise)
    for row, track in np.ndindex(found.shape):
        matrix = np.hstack([np.eye(2), seconds[row] * np.eye(2)])
        gap = position[row] - matrix @ mean[track]
        spread = matrix @ covariance[track] @ matrix.T + noise[row]
        assert found[row, track] == pytest.approx(gap @ np.linalg.solve(spread, gap))


def test_without_tracks_or_detections_there_are_no_pairs():
    rng = np.random.default_rng(0)
    for tracks, detections in ((0, 3), (3, 0), (0, 0)):
        pairs = gated(*scene(rng, tracks, detections, 2, 5.0))
        assert [len(each) for each in pairs] == [0] * 4
