"""How fast image-to-ground mappings are, beside OpenCV's in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.ground.accuracy import (
    IMAGE_SIZE,
    TABLE_K1,
    makers,
    true_camera,
    visible_grid,
)
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import CameraMapping

Floats = NDArray[np.float64]
SPACING_M = 8.0
NOISE_PX2 = np.eye(2)


def bench_ground(count: int = 200_000, rounds: int = 7, seed: int = 1) -> Figures:
    """
    Measure points mapped to the ground a second, on one core.

    Parameters
    ----------
    count : int
        Points at a time.
    rounds : int
        How often each method maps them, in turn; the fastest counts.
    seed : int
        Of the points and clicks.

    """
    random = np.random.default_rng(seed)
    camera = CameraMapping(true_camera(TABLE_K1), IMAGE_SIZE)
    grid = visible_grid(camera, SPACING_M)
    clicks = camera.image_from_ground(grid) + random.normal(0, 0.5, grid.shape)
    low, high = clicks.min(axis=0), clicks.max(axis=0)
    pixel = random.uniform(low, high, (count, 2))
    maps = {name: make(grid, clicks) for name, make in makers(grid).items()}
    works: dict[str, Callable[[], object]] = {
        'fitted': lambda: maps['fitted'].locate(pixel, NOISE_PX2),
        'cell': lambda: maps['cell'].locate(pixel, NOISE_PX2),
        'iterated': lambda: maps['iterated'].ground_from_image(pixel),
        'homography': lambda: maps['homography'].locate(pixel, NOISE_PX2),
        'peer.opencv': lambda: _opencv(camera, pixel),
    }
    best = dict.fromkeys(works, np.inf)
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        for _ in range(rounds):
            for name, work in works.items():
                began = time.perf_counter()
                work()
                best[name] = min(best[name], time.perf_counter() - began)
    finally:
        cv2.setNumThreads(threads)
    return Figures(
        'bench_ground',
        'mctrack bench ground',
        {
            'points': count,
            'rounds': f'{rounds}, the fastest counts',
            'grid_cells_m': SPACING_M,
            'fitted, cell, homography': 'position and covariance',
            'iterated': 'position, to 1 px',
            'peer.opencv': 'undistortPoints and perspectiveTransform: position alone',
        },
        {f'{name}.points_per_s': count / seconds for name, seconds in best.items()},
    )


def _opencv(camera: CameraMapping, pixel: Floats) -> Floats:
    """Map pixels with OpenCV's own functions."""
    across, down, x, y = camera.camera.intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]])
    straight = cv2.undistortPoints(pixel[:, None], matrix, camera.camera.distortion)
    pose = np.column_stack([camera.camera.rotation[:, :2], camera.camera.translation])
    return np.asarray(cv2.perspectiveTransform(straight, np.linalg.inv(pose)))
