import numpy as np

from fusion_scenes import detections
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.sensor_bias.comparisons import REACH_M, ROOM, compare

CONFIG = JointConfig()
TICK_NS = 1_000_000_000
CAMERAS = 4


def scene(seed):
    """Return a table's states, looks, and who saw whom, with misses and false detections."""
    rng = np.random.default_rng(seed)
    count = 12
    state = np.column_stack([rng.uniform(0, 25, (count, 2)), rng.normal(0, 3, (count, 2))])
    images, seen, first = [], np.full((count, CAMERAS), -1), 0
    for camera in range(CAMERAS):
        stamp_ns = TICK_NS - int(rng.integers(0, 40_000_000))
        rows = np.flatnonzero(rng.random(count) < 0.8)
        places = state[rows, :2] + (stamp_ns - TICK_NS) / 1e9 * state[rows, 2:]
        places = np.vstack([places + rng.normal(0, 0.2, places.shape), rng.uniform(0, 25, (2, 2))])
        images.append(detections(stamp_ns, places, 0.2))
        seen[rows, camera] = first + np.arange(len(rows))
        first += len(places)
    batch = Batch(images, range(CAMERAS), TICK_NS, CONFIG)
    return state, seen, batch


def slowly(state, seen, batch, doubt):
    """Return what `compare` should: camera, residual and covariance of each comparison."""
    found = []
    for track, rows in enumerate(seen):
        place = batch.position - batch.seconds[batch.image, None] * state[track, 2:]
        for own in range(CAMERAS):
            others = [row for camera, row in enumerate(rows) if row >= 0 and camera != own]
            if len(others) < 2:
                continue
            weights = [
                np.linalg.inv(batch.noise[row] + doubt[batch.camera[row]] * np.eye(2))
                for row in others
            ]
            spread = np.linalg.inv(sum(weights))
            middle = spread @ sum(w @ place[row] for w, row in zip(weights, others))
            visible = (np.delete(seen, own, axis=1) >= 0).any(axis=1)
            visible[track] = False
            gaps = np.linalg.norm(state[visible, :2] - state[track, :2], axis=1)
            room = min(REACH_M, gaps.min(initial=np.inf) / 2)
            distance = np.linalg.norm(place - middle, axis=1)
            near = np.flatnonzero((batch.camera == own) & (distance < room))
            if len(near) != 1:
                continue
            expected = spread + batch.noise[near[0]]
            if ROOM * np.trace(expected) / 2 <= room**2:
                found.append((own, place[near[0]] - middle, expected))
    return sorted(found, key=lambda each: each[0])


def test_comparisons_are_those_of_plain_matrices():
    total = 0
    for seed in range(20):
        state, seen, batch = scene(seed)
        doubt = np.array([0.0, 0.3, 0.0, 0.0])
        expected = slowly(state, seen, batch, doubt)
        found = compare(state, seen, 0, batch, batch.position, batch.noise, doubt)
        assert found[0].tolist() == [own for own, _, _ in expected]
        assert np.allclose(found[1], np.reshape([r for _, r, _ in expected], (-1, 2)))
        assert np.allclose(found[2], np.reshape([c for _, _, c in expected], (-1, 2, 2)))
        total += len(expected)
    assert total > 100


def test_a_detection_far_off_counts_whatever_it_was_associated_with():
    state = np.array([[0.0, 0.0, 0.0, 0.0]])
    images = [detections(TICK_NS, [place]) for place in ((0, 0), (0, 0), (2, 0))]
    batch = Batch(images, range(3), TICK_NS, CONFIG)
    seen = np.array([[0, 1, -1]])
    camera, residual, _ = compare(state, seen, 0, batch, batch.position, batch.noise, np.zeros(3))
    assert camera.tolist() == [2]
    assert np.allclose(residual, [[2.0, 0.0]])
