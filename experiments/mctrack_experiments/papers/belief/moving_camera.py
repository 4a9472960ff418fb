"""How far the calibration of cameras drifts that pan, tilt and zoom for a minute (Figure 3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import run_spread
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.perception.moving_camera.moving_camera import (
    CameraMotion,
    CameraView,
    MovingCamera,
)
from mctrack_ros.simulation import PTZ, Camera, PtzScenario
from mctrack_ros.simulation.pitch import field

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

SECONDS = 60.0
CLICK_NOISE_PX = 0.5
_GRID_M = 4.0
_EVERY = 5
_TILES_S = 4.0
_COLOURS = ((40, 40, 220), (220, 160, 30))

Job = tuple[int, int, bool, float]


def reproduce_moving_camera(
    seeds: Sequence[int],
    progress: Callable[[str], None] = lambda line: None,
    image: Path | None = None,
    seconds: float = SECONDS,
) -> Figures:
    """
    Follow two panning cameras on each seed, with the pitch's lines and without.

    Parameters
    ----------
    seeds : sequence of int
        One match each.
    progress : callable
        Told what is done.
    image : Path, optional
        Where to draw the paper's Figure 3 of the first seed.
    seconds : float
        Length of each match, s.

    """
    jobs = [
        (seed, camera, has_lines, seconds)
        for seed in seeds
        for camera in (0, 1)
        for has_lines in (True, False)
    ]
    results = run_spread(
        errors, jobs, lambda done, total: progress(f'{done} of {total} cameras are followed')
    )
    figures: dict[str, float] = {}
    for name, with_lines in (('lines', True), ('features', False)):
        chosen = [result for job, result in zip(jobs, results) if job[2] is with_lines]
        figures |= _figures(name, chosen)
    if image is not None:
        cv2.imwrite(str(image), mosaic(seeds[0], seconds))
    return Figures('moving_camera', 'mctrack reproduce moving_camera', _protocol(seeds), figures)


def errors(job: Job) -> tuple[Floats, Floats, int]:
    """
    Follow one camera.

    Returns
    -------
    errors : (n,) array
        Of all places of a grid on the pitch in view, in every fifth image, m.
    last : (k,) array
        Those of the last image.
    lost : int
        Images in which the camera was lost.

    """
    every, last, lost = [], np.empty(0), 0
    for index, (camera, view, _) in enumerate(followed(*job)):
        lost += view.state is CameraMotion.LOST
        if index % _EVERY == 0:
            last = _missed(camera, view)
            every.append(last)
    return np.concatenate(every), last, lost


def followed(
    seed: int, camera_index: int, has_lines: bool, seconds: float
) -> Iterator[tuple[Camera, CameraView, Image]]:
    """Yield the true camera, what is estimated of it, and the image."""
    world = PTZ.world(PtzScenario(seed=seed, duration_s=seconds))
    camera, renderer = world.cameras[camera_index], PTZ.renderer(world, camera_index)
    start = clicked(camera.at(0), np.random.default_rng([seed, 8, camera_index]))
    moving = MovingCamera(start, field.painted_lines() if has_lines else ())
    for step in range(world.scenario.steps):
        image, view = renderer.frame(step)
        yield camera.at(step), moving.step(image, view.box), image


def clicked(camera: Camera, rng: np.random.Generator) -> ProjectiveMapping:
    """Return the calibration of an image by clicks on a grid of its ground."""
    ground = _grid()[camera.sees(_on_ground(_grid()))]
    clicks = camera.project(_on_ground(ground)) + rng.normal(
        scale=CLICK_NOISE_PX, size=ground.shape
    )
    return ProjectiveMapping.from_points(ground, clicks, camera.size)


def mosaic(seed: int, seconds: float = SECONDS) -> Image:
    """Draw the images of a camera over one another where its calibration puts them (Figure 3)."""
    world = PTZ.world(PtzScenario(seed=seed, duration_s=seconds))
    wide = world.cameras[0].mosaic
    drawn = np.zeros((*wide.size[::-1], 3), np.uint8)
    every = round(_TILES_S * world.scenario.rate_hz)
    outlines = []
    ground = wide.matrix[:, [0, 1, 3]]
    half = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1]])
    for index, (_, view, image) in enumerate(followed(seed, 0, True, seconds)):
        if index % every == 0:
            warp = half @ ground @ view.mapping.ground_from_image_homography @ np.linalg.inv(half)
            tile = cv2.warpPerspective(image, warp, wide.size)
            seen = cv2.warpPerspective(np.full(image.shape[:2], 255, np.uint8), warp, wide.size)
            drawn[seen == 255] = tile[seen == 255]
            width, height = view.mapping.image_size
            corners = np.array([[(0, 0), (width, 0), (width, height), (0, height)]], np.float64)
            outlines.append(cv2.perspectiveTransform(corners, warp).round().astype(np.int32))
    cv2.polylines(drawn, outlines, True, _COLOURS[0], 1, cv2.LINE_AA)
    for line in field.painted_lines():
        places = _on_ground(line)
        if (wide.depth(places) > 1).all():
            pixel = wide.project(places).round().astype(np.int32)
            cv2.polylines(drawn, [pixel], False, _COLOURS[1], 1, cv2.LINE_AA)
    return drawn


def _missed(camera: Camera, view: CameraView) -> Floats:
    """Return how far off the places in an image are put on the ground, (n,) m."""
    ground = _grid()[camera.sees(_on_ground(_grid()))]
    put = view.mapping.ground_from_image(camera.project(_on_ground(ground)))
    return np.asarray(np.linalg.norm(put - ground, axis=1))


def _grid() -> Floats:
    x, y = np.arange(2.5, field.LENGTH_M, _GRID_M), np.arange(2.0, field.WIDTH_M, _GRID_M)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _on_ground(place: Floats) -> Floats:
    return np.column_stack([place, np.zeros(len(place))])


def _figures(name: str, results: Sequence[tuple[Floats, Floats, int]]) -> dict[str, float]:
    """Return the spread of errors; an image's drift is the median of its places."""
    every = np.concatenate([result[0] for result in results])
    ends = np.array([np.nanmedian(result[1]) for result in results])
    return {
        f'{name}.median_m': float(np.nanmedian(every)),
        f'{name}.p95_m': float(np.nanpercentile(every, 95)),
        f'{name}.worst_m': float(np.nanmax(every)),
        f'{name}.end_median_m': float(np.median(ends)),
        f'{name}.end_worst_m': float(ends.max()),
        f'{name}.lost_images': float(sum(result[2] for result in results)),
    }


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    return {
        'cameras': f'two of scene ptz for {SECONDS:g} s, seeds {", ".join(map(str, seeds))}',
        'start': f'a calibration from clicks on a grid of {_GRID_M:g} m, '
        f'{CLICK_NOISE_PX:g} px of noise',
        'error': f'distance on the ground of all places of that grid in view, every {_EVERY}th '
        'image; end: the median over the places of the last one',
        'lines': 'features and painted lines; features: features alone',
        'people': 'masked by their true boxes',
    }
