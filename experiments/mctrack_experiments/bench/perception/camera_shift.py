"""What watching for a moved camera costs, beside phase correlation in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.real.watched_scene import KINDS, RATE_HZ, SIZE, WatchedScene
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.perception.camera_shift.monitor import (
    PERIOD_S,
    CameraShiftConfig,
    CameraShiftMonitor,
)

Image = NDArray[np.uint8]
PEER_EVERY = 50
SEEN_S = 16.0  # before the camera is covered
COVER_GRAIN_PX = 3


def bench_camera_shift(images_count: int = 2000, seed: int = 1) -> Figures:
    """
    Measure what watching costs an image, on one core, beside phase correlation.

    Parameters
    ----------
    images_count : int
        Images of each kind of scene.
    seed : int
        Of the scenes.

    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        figures = {
            name: value
            for kind in KINDS
            for name, value in _costs(kind, images_count, seed).items()
        }
        figures['covered.ms_per_image'] = _covered_ms(images_count, seed)
    finally:
        cv2.setNumThreads(threads)
    figures['ms_per_image'] = max(figures[f'{kind}.ms_per_image'] for kind in (*KINDS, 'covered'))
    return Figures(
        'bench_camera_shift',
        'mctrack bench camera-shift',
        {
            'images': f'{images_count} of {SIZE[0]} x {SIZE[1]} px at {RATE_HZ:g} Hz in each '
            'kind of scene, from the start; drawing is not counted',
            'covered': f'as many, of something with texture before the lens after {SEEN_S:g} s of '
            'the square',
            'ms_per_image': 'mean, exchanges and failures included; processor time',
            'peer.phase_correlation': 'cv2.phaseCorrelate of two full images, made grey',
        },
        figures,
    )


def _costs(kind: str, count: int, seed: int) -> dict[str, float]:
    scene, monitor = (
        WatchedScene(kind, seed, count / RATE_HZ),
        CameraShiftMonitor(CameraShiftConfig()),
    )
    between = round(PERIOD_S * RATE_HZ)
    first = image = scene.image(0.0)
    spent, peer = np.zeros(count), []
    for index in range(count):
        looked_at = index % between == 0
        if looked_at:  # the others are not looked at
            image = scene.image(index / RATE_HZ)
        spent[index] = _seconds(monitor.watch, image, round(index / RATE_HZ * 1e9))
        if index % PEER_EVERY == 0:
            peer.append(_seconds(_phase_correlation, first, image))
    looks = spent[::between]
    return {
        f'{kind}.ms_per_image': float(spent.mean()) * 1e3,
        f'{kind}.ms_per_look': float(looks.mean()) * 1e3,
        f'{kind}.ms_per_look_p99': float(np.percentile(looks, 99)) * 1e3,
        f'{kind}.peer.phase_correlation.ms_per_image': float(np.mean(peer)) * 1e3,
    }


def _covered_ms(count: int, seed: int) -> float:
    """Return what an image costs while the reference is looked for and never found, ms."""
    scene, monitor = WatchedScene('square', seed, SEEN_S), CameraShiftMonitor(CameraShiftConfig())
    for time_s in np.arange(0, SEEN_S, PERIOD_S).tolist():
        monitor.watch(scene.image(time_s), round(time_s * 1e9))
    noise = np.random.default_rng(seed).integers(0, 256, (SIZE[1], SIZE[0], 3), np.uint8)
    cover = np.asarray(cv2.GaussianBlur(noise, (0, 0), COVER_GRAIN_PX), np.uint8)
    stamps = [round((SEEN_S + index / RATE_HZ) * 1e9) for index in range(count)]
    return float(np.mean([_seconds(monitor.watch, cover, stamp) for stamp in stamps])) * 1e3


def _seconds(work: Callable[..., object], *arguments: object) -> float:
    """Return how long the processor works, s."""
    began = time.thread_time()
    work(*arguments)
    return time.thread_time() - began


def _phase_correlation(first: Image, image: Image) -> object:
    first_grey, grey = (
        cv2.cvtColor(one, cv2.COLOR_BGR2GRAY).astype(np.float32) for one in (first, image)
    )
    return cv2.phaseCorrelate(first_grey, grey)
