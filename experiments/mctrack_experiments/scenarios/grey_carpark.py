"""The grey car park: people and cars, four cameras, from images to tracks by defaults."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import Progress, silent
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import ClassCode, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import GreyCarParkScenario
from mctrack_ros.simulation.carpark import CarParkWorld, grey_carpark_world
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site

GATES_M = {'people': 1.0, 'vehicles': 2.5}
AREA = (0.0, -4.0, 40.0, 31.0)
"""What counts, x0, y0, x1, y1, m: the area of the site."""
MEASURES = ('mota', 'idf1', 'precision', 'recall', 'switches', 'mean_distance')


def reproduce_grey_carpark(
    seeds: Sequence[int], progress: Progress = silent, duration_s: float = 60.0
) -> Figures:
    """
    Render and track recordings of the grey car park.

    Parameters
    ----------
    seeds : sequence of int
        One recording each.
    progress : callable
        Told how many are done, of how many.
    duration_s : float
        Length of each, s.

    """
    scored = []
    for done, seed in enumerate(seeds):
        progress(done, len(seeds))
        scored.append(_scored(GreyCarParkScenario(seed=seed, duration_s=duration_s)))
    progress(len(seeds), len(seeds))
    figures: dict[str, float] = {}
    for key in scored[0]:
        values = [scores[key] for scores in scored]
        figures[key] = float(np.mean(values))
        figures[f'{key}.sd'] = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    _, why = with_tracker(load_site(config_file('grey_carpark.yaml')))
    protocol = {
        'scene': f'grey car park, four cameras, {duration_s:g} s of 12.5 images a second each',
        'seeds': ', '.join(map(str, seeds)),
        'settings': 'config/grey_carpark.yaml: calibration by clicks of half a pixel of noise, '
        'rate, and that there are vehicles; all else by default, no background is given',
        'tracker': why,
        'gates': ', '.join(f'{name} {gate:g} m' for name, gate in GATES_M.items()),
        'counted': 'whoever has his feet in an image, in the area of the site; a parked car is '
        'ignored, and so is a track on it',
        'figures': 'means over the recordings; sd: their standard deviation',
    }
    return Figures('grey_carpark', 'mctrack reproduce grey_carpark', protocol, figures)


def _scored(scenario: GreyCarParkScenario) -> dict[str, float]:
    """Render and track one recording."""
    world = grey_carpark_world(scenario)
    with tempfile.TemporaryDirectory(prefix='mctrack_carpark_') as name:
        folder = Path(name)
        simulate(scenario, folder / 'bag', world=world)
        track_bag(folder / 'bag', folder / 'out', load_site(config_file('grey_carpark.yaml')))
        with BagReader(folder / 'out' / 'bag') as bag:
            instants = [rows for rows, _ in bag.rows('/tracks', Tracks)]
    return scores_of(world, instants)


def scores_of(world: CarParkWorld, instants: Sequence[Tracks]) -> dict[str, float]:
    """Return figures of people and of vehicles, given the tracks of all ticks."""
    period_ns = round(world.scenario.period_s * 1e9)
    origin_ns = world.scenario.stamp_ns(0) - period_ns // 2
    figures: dict[str, float] = {}
    for kind, gate_m in GATES_M.items():
        is_vehicle = kind == 'vehicles'
        told = [
            rows.select((rows.class_id == ClassCode.VEHICLE) == is_vehicle) for rows in instants
        ]
        tracks = Trajectories.from_tracks(told, period_ns, origin_ns)
        tracks = tracks.select(_inside(tracks.position))
        scores = evaluate_ground(_truth(world, is_vehicle), tracks, gate_m)
        figures |= {f'{kind}.{name}': float(getattr(scores, name)) for name in MEASURES}
    return figures


def _truth(world: CarParkWorld, is_vehicle: bool) -> Trajectories:
    """Return who is seen; parked cars are to be ignored."""
    kind = (world.class_id == ClassCode.VEHICLE) == is_vehicle
    there = world.feet_in_view.any(axis=1) | world.parked
    step, index = np.nonzero(there & kind)
    place = world.motion.position[step, index]
    counts = _inside(place)
    step, index, place = step[counts], index[counts], place[counts]
    return Trajectories(step, index + 1, place, ignore=world.parked[step, index])


def _inside(place: NDArray[np.float64]) -> NDArray[np.bool_]:
    low, high = np.array(AREA).reshape(2, 2)
    return np.asarray(((place >= low) & (place <= high)).all(axis=1))
