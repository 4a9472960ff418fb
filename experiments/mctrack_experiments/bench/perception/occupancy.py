"""What joint occupancy takes for a tick: a large square with eight cameras, and the terrace."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_experiments.bench.perception.square import (
    RATE_HZ,
    SIDE_M,
    SIZE,
    square_world,
    ticks_of,
    views_of,
)
from mctrack_experiments.datasets.epfl_terrace import (
    CAMERAS,
    PERIOD_NS,
    read_identities,
    read_positions,
)
from mctrack_experiments.real.terrace import four_cameras as terrace
from mctrack_ros.config import config_from
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import FusionOutput, OpenViews, open_fusion
from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.occupancy.config import OccupancyConfig
from mctrack_ros.fusion.occupancy.masks import Masks
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.views import Views
from mctrack_ros.interfaces import CameraRows, RowsTick
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.video.videos import START_NS
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import track_bag

Floats = NDArray[np.float64]
SightingTick = RowsTick[OccupancyInput]

WARM_UP = 20
"""Ticks before time and scores count: loops are compiled, tracks begin."""
GATES_M = {'': 1.0, 'gate_half_metre.': 0.5}
NEAR_M = 1.0
"""People and truth farther apart are not the same."""


def bench_occupancy(data: Path, seconds: float = 60.0, seed: int = 1) -> Figures:
    """
    Time joint occupancy on one core, and hold its places against the truth.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    seconds : float
        How long people cross the square.
    seed : int
        Of them.

    """
    return Figures(
        'bench_occupancy',
        'mctrack bench occupancy',
        {
            'square': f'{SIDE_M:g} x {SIDE_M:g} m, eight cameras of {SIZE[0]} x {SIZE[1]} px at '
            f'{RATE_HZ:g} Hz, 20 people, {seconds:g} s, seed {seed}; masks: true silhouettes with '
            'holes and specks, reduced as camera nodes do it',
            'terrace': 'masks and detections that the run of terrace4 records, fused again',
            'ms': f'processor time of the whole step of the tracker, after {WARM_UP} ticks',
            'found_without_tracks': 'share of people that the masks of a tick alone give within '
            f'{NEAR_M:g} m: who is small beside many larger people explains little of all masks',
            'nees': 'squared errors of the people found, without tracks or a prior, over their '
            "covariances: an honest mean is 2; the terrace's truths are uncertain by as much as "
            'they differ from each other and from what is found (three-cornered hat), which is '
            'added to the covariance',
        },
        _square(seconds, seed) | _terrace(data),
    )


def _square(seconds: float, seed: int) -> dict[str, float]:
    """Return times, scores and NEES of the square."""
    world = square_world(seed, seconds)
    config = config_from(
        OccupancyConfig, {'tracker': 'occupancy', 'batching': {'period': 1 / RATE_HZ}}
    )
    names, ticks = tuple(camera.name for camera in world.cameras), ticks_of(world)

    def views() -> Views:
        return views_of(world.views(0))

    outputs, figures = _driven(config, names, ticks, views)
    period_ns = round(1e9 / RATE_HZ)
    frames = range(WARM_UP, len(ticks))
    tracks = Trajectories.from_tracks(
        [output.tracks for output in outputs], period_ns, world.scenario.start_ns
    ).at_frames(frames)
    step, person = np.nonzero(world.active)
    place = world.motion.position[step, person]
    truth = Trajectories(step, person + 1, place).at_frames(frames)
    for prefix, gate in GATES_M.items():
        scores = evaluate_ground(truth, tracks, gate)
        for name in ('moda', 'mota', 'idf1', 'switches'):
            figures[prefix + name] = float(getattr(scores, name))
    errors, covariances = [], []
    for index, (mean, covariance) in enumerate(_people(config, names, ticks, views)):
        found, true = _pairs(mean, world.motion.position[index])
        errors.append(mean[found] - world.motion.position[index][true])
        covariances.append(covariance[found])
    figures['nees'] = _nees(np.concatenate(errors), np.concatenate(covariances))
    figures['found_without_tracks'] = sum(map(len, errors)) / len(place)
    return {f'square.{name}': value for name, value in figures.items()}


def _terrace(data: Path) -> dict[str, float]:
    """Return times and NEES of the terrace."""
    with tempfile.TemporaryDirectory(prefix='mctrack_occupancy_') as name:
        folder = Path(name)
        terrace.write_images(data, folder / 'bag')
        site = terrace.write_site(data, folder, 'occupancy')
        track_bag(folder / 'bag', folder / 'out', site)
        with BagReader(folder / 'out' / 'bag') as bag:
            ticks = list(recorded_ticks(bag, site.camera_names, site.fusion))
        assert isinstance(site.fusion, OccupancyConfig)
        _, figures = _driven(site.fusion, site.camera_names, ticks, site.views)
        people = list(_people(site.fusion, site.camera_names, ticks, site.views))
    positions, identities = read_positions(data), read_identities(data, CAMERAS)
    rows = []
    for tick, (mean, covariance) in zip(ticks, people):
        frame = (tick.stamp_ns - START_NS) // PERIOD_NS
        truths = [truth.position[truth.frame == frame] for truth in (positions, identities)]
        if frame >= terrace.FIRST_IMAGE and all(len(truth) for truth in truths):
            near = [dict(zip(*map(np.ndarray.tolist, _pairs(mean, truth)))) for truth in truths]
            rows += [
                (mean[k] - truths[0][near[0][k]], mean[k] - truths[1][near[1][k]], covariance[k])
                for k in near[0].keys() & near[1].keys()
            ]
    one, other, covariance = (np.array(column) for column in zip(*rows))
    squares = [(each**2).mean() for each in (one, other, one - other)]
    truth_variance = max((squares[0] + squares[2] - squares[1]) / 2, 0.0)
    figures['nees'] = _nees(one, covariance + truth_variance * np.eye(2))
    figures['nees_if_truth_were_exact'] = _nees(one, covariance)
    figures['truth_sigma_m'] = float(np.sqrt(truth_variance))
    return {f'terrace.{name}': value for name, value in figures.items()}


def _driven(
    config: OccupancyConfig,
    names: tuple[str, ...],
    ticks: Iterable[SightingTick],
    views: OpenViews,
) -> tuple[list[FusionOutput], dict[str, float]]:
    """Return the outputs of a new tracker, and the processor time of its steps, ms."""
    tracker, outputs, spent_ms = open_fusion(config, names, views=views), [], []
    for tick in ticks:
        begun_s = time.thread_time()
        outputs.append(tracker.step(tick))
        spent_ms.append(1e3 * (time.thread_time() - begun_s))
    counted = np.array(spent_ms[WARM_UP:])
    p50, p99 = np.percentile(counted, [50, 99]).tolist()
    return outputs, {'mean_ms': float(counted.mean()), 'p50_ms': p50, 'p99_ms': p99}


def _people(
    config: OccupancyConfig,
    names: tuple[str, ...],
    ticks: Iterable[SightingTick],
    views: OpenViews,
) -> Iterable[tuple[Floats, Floats]]:
    """Yield means and covariances of the people that the masks of each tick give by themselves."""
    scene = Scene(views(), names, config.people)
    masks = Masks(names, scene, config.people.person_cost)
    prior, within_cell = np.zeros(len(scene.position)), np.eye(2) * scene.step**2 / 12
    for tick in ticks:
        told = [CameraRows(each.camera, each.rows.foreground) for each in tick.messages]
        masks.take(told, tick.stamp_ns)
        people = masks.explained(masks.left_out(tick.stamp_ns), prior, tick.stamp_ns)
        yield people.mean, people.covariance + within_cell


def _pairs(found: Floats, true: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return which people are who, within `NEAR_M`."""
    distance = np.linalg.norm(found[:, None] - true, axis=2)
    row, column = linear_sum_assignment(np.minimum(distance, NEAR_M))
    near = distance[row, column] < NEAR_M
    return row[near], column[near]


def _nees(error: Floats, covariance: Floats) -> float:
    weighed = np.linalg.solve(covariance, error[..., None])[..., 0]
    return float((error * weighed).sum(axis=1).mean())
