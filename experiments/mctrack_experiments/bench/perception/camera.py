"""How many images a second a camera's trackers take on one core."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import count

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.perception.pitch import (
    CAMERA,
    WARM_UP,
    PitchBench,
    bare_contours,
    mog2_contours,
)
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import GroundMapping, ProjectiveMapping
from mctrack_ros.perception.background.scene import Scene
from mctrack_ros.perception.silhouettes import SilhouetteConfig, SilhouettePipeline
from mctrack_ros.perception.silhouettes.foreground.components import find_silhouettes

Image = NDArray[np.uint8]
SIZE = (640, 480)
PITCH_SIZE = '768 x 576 px at 25 Hz'
RATE_HZ = 25.0
WALKERS, CARS = 8, 2
NOISE = 2.0  # grey levels
ROUNDS = 3


def bench_camera(images_count: int = 250, seed: int = 1) -> Figures:
    """
    Time the default tracker on the pitch and the silhouettes tracker on a drawn car park.

    Parameters
    ----------
    images_count : int
        Images in a row; they are played several times, and the fastest time counts.
    seed : int
        Of the scenes.

    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        figures = _pitch(images_count, seed)
        images = _images(images_count, seed)
        figures |= _silhouettes(images)
        figures['peer.mog2_components.fps'] = 1.0 / _seconds(_peer, images)
    finally:
        cv2.setNumThreads(threads)
    return Figures(
        'bench_camera',
        'mctrack bench camera',
        {
            'decoded, jpeg': f'{images_count} images of {CAMERA} of pitch5 on which 25 people '
            f'play, {PITCH_SIZE}, everything on, with feedback, after {WARM_UP} images more; '
            'persons: seen in an image; decoded is without decompression; processor time, '
            f'best of {ROUNDS}; stages: each timed alone, tracking is the rest',
            'crowded, crowded50': '100 and 50 people: four matches and two on one pitch at once',
            'peer.mog2_contours': 'OpenCV MOG2 without shadows, opening, outer contours, on the '
            'same images, decoded',
            'peer.bare_contours': 'difference from a fixed image, threshold, outer contours: '
            'the least that can be done',
            'silhouettes': f'{images_count} images of {SIZE[0]} x {SIZE[1]} px at '
            f'{RATE_HZ:g} Hz, {WALKERS} pedestrians and {CARS} vehicles moving, everything on; '
            f'decoding is not counted; processor time, best of {ROUNDS}',
            'peer.mog2_components': 'OpenCV MOG2 without shadows, opening, components with '
            'statistics, on the same grey images',
        },
        figures,
    )


def _pitch(images_count: int, seed: int) -> dict[str, float]:
    """Return images of the pitch a second, what the stages cost, and how both grow."""
    bench = PitchBench(1, images_count, seed)
    whole = _best_of(bench)
    stages = bench.stages()
    figures = {
        'decoded.fps': 1e3 / whole['camera_ms'],
        'jpeg.fps': 1e3 / (whole['camera_ms'] + whole['decoding_ms']),
        'decoded.persons': whole['persons'],
        'decoded.decoding_ms': whole['decoding_ms'],
        **{f'decoded.{name}': spent for name, spent in stages.items()},
        'decoded.tracking_ms': whole['camera_ms'] - sum(stages.values()),
    }
    for name, work in {'mog2': mog2_contours(), 'bare': bare_contours()}.items():
        figures[f'peer.{name}_contours.fps'] = bench.peer(work)
    for name, matches in {'crowded50': 2, 'crowded': 4}.items():
        crowd = _best_of(PitchBench(matches, images_count // 2, seed))
        figures |= {f'{name}.fps': 1e3 / crowd['camera_ms'], f'{name}.persons': crowd['persons']}
    return figures


def _best_of(bench: PitchBench) -> dict[str, float]:
    """Return the figures of the fastest of some rounds."""
    return min((bench.whole() for _ in range(ROUNDS)), key=lambda each: each['camera_ms'])


def _silhouettes(images: Sequence[Image]) -> dict[str, float]:
    """Return images a second, and what the stages cost, ms an image."""
    config = SilhouetteConfig()

    pipeline, clock = SilhouettePipeline(config, _mapping()), count()

    def everything(images: Sequence[Image]) -> None:
        for image in images:
            pipeline.step(image, _stamp_ns(next(clock)), None)

    def masks(images: Sequence[Image]) -> list[tuple[Image, Image]]:
        own = config.background
        scene = Scene(own.background(), own.shadows(), _mapping(), 1.0, None, images[0])
        nobody, found = np.zeros(images[0].shape[:2], np.uint8), []
        for index, image in enumerate(images):
            side, stamp_ns = own.smoothing_px, _stamp_ns(index)
            smooth = np.asarray(cv2.blur(image, (side, side)), np.uint8)
            mask = scene.foreground(smooth, stamp_ns)
            if mask is not None:
                scene.background.learn(smooth, mask, nobody, nobody, stamp_ns)
                grey = np.asarray(cv2.cvtColor(smooth, cv2.COLOR_BGR2GRAY), np.uint8)
                found.append((mask.copy(), grey))
        return found

    def components(found: Sequence[tuple[Image, Image]]) -> None:
        for mask, grey in found:
            find_silhouettes(mask, grey, config.components)

    whole = _seconds(everything, images)
    background = _seconds(masks, images)
    labelling = _seconds(components, masks(images))
    return {
        'silhouettes.fps': 1.0 / whole,
        'silhouettes.background_ms': background * 1e3,
        'silhouettes.components_ms': labelling * 1e3,
        'silhouettes.tracking_ms': (whole - background - labelling) * 1e3,
    }


def _seconds(work: Callable[..., object], images: Sequence[object]) -> float:
    """Return the processor time, s, for one of the images, the best of some rounds."""
    spent = []
    for _ in range(ROUNDS):
        began = time.thread_time()
        work(images)
        spent.append(time.thread_time() - began)
    return min(spent) / len(images)


def _peer(images: Sequence[Image]) -> None:
    model = cv2.createBackgroundSubtractorMOG2(detectShadows=False)
    kernel = np.ones((3, 3), np.uint8)
    for image in images:
        mask = model.apply(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel)
        cv2.connectedComponentsWithStats(mask, connectivity=4, ltype=cv2.CV_16U)


def _stamp_ns(index: int) -> int:
    return round((index + 1) / RATE_HZ * 1e9)


def _mapping() -> GroundMapping:
    """Return a camera 9 m up that looks at the ground 20 m away."""
    eye = np.array([0.0, -20.0, 9.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.array([1.0, 0.0, 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[600.0, 0, SIZE[0] / 2], [0, 600.0, SIZE[1] / 2], [0, 0, 1]])
    return ProjectiveMapping(intrinsics @ np.column_stack([rotation, -rotation @ eye]), SIZE)


def _images(length: int, seed: int) -> list[Image]:
    """Draw a grey ground on which boxes of the size of people and cars go to and fro."""
    rng, (width, height) = np.random.default_rng(seed), SIZE
    ground = np.asarray(cv2.GaussianBlur(rng.normal(110, 60, (height, width)), (0, 0), 3))
    kinds = [(22, 60, 1.0)] * WALKERS + [(140, 70, 3.0)] * CARS
    start = rng.uniform(0, width, len(kinds))
    row = rng.uniform(120, height - 10, len(kinds))
    shade = rng.choice([-45, -25, 30, 50], len(kinds))
    images = []
    for index in range(length):
        drawn = ground.copy()
        for (wide, tall, speed), x, bottom, change in (
            zip(kinds, start, row, shade) if index else ()
        ):
            left = int(abs((x + speed * index) % (2 * width) - width) - wide / 2)
            drawn[int(bottom) - tall : int(bottom), max(left, 0) : max(left + wide, 0)] += change
        noisy = np.clip(drawn + rng.normal(0, NOISE, drawn.shape), 0, 255).astype(np.uint8)
        images.append(np.asarray(cv2.cvtColor(noisy, cv2.COLOR_GRAY2BGR), np.uint8))
    return images
