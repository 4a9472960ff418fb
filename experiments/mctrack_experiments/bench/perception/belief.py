"""How many images a second belief propagation tracks on one core."""

from __future__ import annotations

import time

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters, boxes_of

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

TARGETS, PARTICLES, SIZE = 10, 200, (1280, 720)
PERIOD_NS = 40_000_000
WARM_UP = 10
PLACES = {'north': (0.0, -30.0, 12.0), 'south': (6.0, 30.0, 12.0)}


def bench_belief(frames: int = 200, seed: int = 1) -> Figures:
    """
    Time the view filters and the ground node, without and with the likelihood of images.

    Parameters
    ----------
    frames : int
        Images of each camera.
    seed : int
        Of people and particles.

    """
    values: dict[str, float] = {}
    for name, colour_weight in {
        'no_images': 0.0,
        'images': BeliefCameraConfig().colour_weight,
    }.items():
        rate, error = _run(frames, seed, colour_weight)
        values[f'{name}.frames_per_second'] = rate
    values['images.error_m'] = error
    return Figures(
        'bench_belief',
        'mctrack bench belief',
        {
            'frames': f'{TARGETS} targets, {len(PLACES)} cameras of {SIZE[0]} x {SIZE[1]} px, '
            f'{PARTICLES} particles, {frames} images of each, seed {seed}; detectors not counted',
            'frames_per_second': 'ticks with the images of both cameras in a second of processor '
            f'time, after {WARM_UP}',
            'error_m': 'mean distance from the truth',
        },
        values,
    )


def _run(frames: int, seed: int, colour_weight: float) -> tuple[float, float]:
    mappings = {name: ProjectiveMapping(_projection(at), SIZE) for name, at in PLACES.items()}
    views = [
        (
            name,
            ViewFilters(mapping, name, BeliefCameraConfig(colour_weight=colour_weight, seed=seed)),
        )
        for name, mapping in mappings.items()
    ]
    ground = GroundBelief(BeliefConfig(particles=PARTICLES, seed=seed))
    ground.stamp_ns = -PERIOD_NS
    rng = np.random.default_rng(seed)
    for track_id, place in enumerate(_people(0.0)):
        ground.start(track_id + 1, place, 0.01 * np.eye(2))
    spent, errors = 0.0, []
    for index in range(frames):
        stamp_ns, people = index * PERIOD_NS, _people(index * PERIOD_NS * 1e-9)
        images = {name: _drawn(mapping, people, rng) for name, mapping in mappings.items()}
        begun = time.process_time()
        sent = ground.belief()
        told = {name: view.step(images[name], stamp_ns, sent) for name, view in views}
        ground.step(told, stamp_ns)
        spent += (time.process_time() - begun) * (index >= WARM_UP)
        for track_id, target in ground.targets.items():
            mean = target.state[:, :2].mean(axis=0)
            errors.append(float(np.hypot(*(mean - people[track_id - 1]))))
    return (frames - WARM_UP) / spent, float(np.mean(errors))


def _people(seconds: float) -> Floats:
    """Return where people walk in circles that cross, (10, 2) m."""
    row = np.arange(TARGETS)
    angle = 2 * np.pi * row / TARGETS + seconds * np.where(row % 2, 0.25, -0.25)
    radius = 4.0 + row % 5
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def _projection(place: tuple[float, float, float], focal: float = 1100.0) -> Floats:
    forward = -np.asarray(place) / np.linalg.norm(place)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    lens = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1]])
    return np.asarray(lens @ np.column_stack([rotation, -rotation @ np.asarray(place)]))


def _drawn(mapping: ProjectiveMapping, people: Floats, rng: np.random.Generator) -> Image:
    """Draw people in two kits, the far ones first."""
    image = np.full((SIZE[1], SIZE[0], 3), (60, 120, 70), np.uint8)
    foot = mapping.image_from_ground(people)
    height, width = mapping.height_px(people, 1.75), mapping.width_px(people, 0.55)
    box = boxes_of(np.column_stack([foot, height, width]))
    for row in np.argsort(foot[:, 1]):
        left, top, wide, high = np.round(box[row]).astype(int).tolist()
        shirt, shorts = ((40, 40, 200), (230, 230, 230)) if row % 2 else ((200, 60, 40), (20,) * 3)
        middle = top + high // 2
        cv2.rectangle(image, (left, top), (left + wide, middle), shirt, -1)
        cv2.rectangle(image, (left, middle), (left + wide, top + high), shorts, -1)
    noise = rng.integers(0, 9, image.shape, np.uint8)
    return np.asarray(cv2.add(image, noise), np.uint8)
