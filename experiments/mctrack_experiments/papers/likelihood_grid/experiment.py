"""Edges, masks and both on the indoor scene of the likelihood-grid paper and on the terrace."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mctrack_experiments.datasets.epfl_terrace import (
    AREA,
    CAMERAS,
    PERIOD_NS,
    image_files,
    read_identities,
    read_positions,
)
from mctrack_experiments.papers.likelihood_grid.speed import sets_a_second
from mctrack_experiments.real.terrace import four_cameras as terrace
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.clear_mot import clear_mot
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.frames import frames_of, ground_distance, matched
from mctrack_ros.fusion.likelihood_grid.config import LikelihoodGridConfig
from mctrack_ros.interfaces import Tracks
from mctrack_ros.perception.likelihood_grid.edges import LEARNING_IMAGES
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.video.videos import START_NS
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import Source, track_bag
from mctrack_ros.simulation import INDOOR, IndoorScenario
from mctrack_ros.simulation.calibration import write_calibration
from mctrack_ros.simulation.indoor.scenario import EMPTY_STEPS
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import SiteConfig, load_site

PEOPLE = (3, 4, 5, 6)
"""How many, seed by seed, and again."""
GATE_M = 0.5
LIGHT_STEP = 0.3
AFTER_S = 2.0
"""So long after the light has changed a track that ends counts as lost by that, s."""
LIKELIHOOD = {
    'pipeline': {'local_tracker': 'likelihood_grid'},
    'fusion': {'tracker': 'likelihood_grid'},
}
OCCUPANCY = {'fusion': {'tracker': 'occupancy'}}
OTHER_SHAPES = ('person', 'ellipsoid')
OTHER_CAMERAS = (2, 3, 6, 8)
"""How many, beside the paper's four."""
Tell = Callable[[str], None]


def reproduce_grid(
    data: Path, seeds: Sequence[int], progress: Tell = lambda line: None
) -> Figures:
    """
    Track the indoor scene and the terrace by edges, by masks and by both.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    seeds : sequence of int
        Of the indoor scene; constants were chosen on 1, 2 and 4.
    progress : callable
        Told what is done.

    """
    rooms = [IndoorScenario(seed=s, people=n) for s, n in zip(seeds, cycle(PEOPLE))]
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory(prefix='mctrack_grid_') as name:
        folder = Path(name)
        runs = []
        for room in rooms:
            runs.append(_indoor(room, folder))
            progress(f'indoor scene, seed {room.seed}: {runs[-1]}')
        figures |= _pooled(runs)
        for count in OTHER_CAMERAS:
            figures |= _more_cameras(replace(rooms[0], cameras=count), folder)
            progress(f'{count} cameras')
        figures |= _light_step(replace(rooms[-1], light_step=LIGHT_STEP), folder)
        progress('light step')
        figures |= _terrace(data, folder)
        progress('terrace')
        figures |= sets_a_second(IndoorScenario(seed=seeds[0]), _site(folder, LIKELIHOOD))
    return Figures('grid', 'mctrack reproduce grid', _protocol(rooms), figures)


def _indoor(scenario: IndoorScenario, folder: Path) -> dict[str, dict[str, float]]:
    """Return the scores of one recording by edges, masks and both."""
    bag, out = folder / 'bag', folder / 'out'
    simulate(scenario, bag, overwrite=True)
    truth = _tracks_of(bag, '/truth/tracks', scenario)
    site = _site(folder, LIKELIHOOD)
    track_bag(bag, out, site, overwrite=True)
    scores = {'both': _scores(truth, _tracks_of(out / 'bag', '/tracks', scenario))}
    scores['edges'] = _scores(truth, _trajectories(edges_alone(out / 'bag', site), scenario))
    for shape in OTHER_SHAPES:
        site = _site(folder, _shaped(shape))
        track_bag(bag, out, site, overwrite=True)
        edges = _trajectories(edges_alone(out / 'bag', site), scenario)
        scores[f'edges_{shape}'] = _scores(truth, edges)
        scores[f'both_{shape}'] = _scores(truth, _tracks_of(out / 'bag', '/tracks', scenario))
    site = _site(folder, LIKELIHOOD)
    track_bag(Source(bag, first_pass=False), out, site, overwrite=True)
    scores['paper'] = _scores(truth, _trajectories(edges_alone(out / 'bag', site), scenario))
    track_bag(bag, out, _site(folder, OCCUPANCY), overwrite=True)
    scores['occupancy'] = _scores(truth, _tracks_of(out / 'bag', '/tracks', scenario))
    return scores


def _shaped(shape: str) -> dict[str, Any]:
    """Return the settings of likelihoods of another shape."""
    return LIKELIHOOD | {'pipeline': LIKELIHOOD['pipeline'] | {'grid': {'shape': shape}}}


def _more_cameras(scenario: IndoorScenario, folder: Path) -> dict[str, float]:
    """Return the scores by edges and masks of another number of cameras."""
    bag, out = folder / 'bag', folder / 'out'
    simulate(scenario, bag, overwrite=True)
    track_bag(bag, out, _site(folder, LIKELIHOOD, scenario), overwrite=True)
    truth = _tracks_of(bag, '/truth/tracks', scenario)
    scores = _scores(truth, _tracks_of(out / 'bag', '/tracks', scenario))
    return {f'cameras_{scenario.cameras}.{name}': value for name, value in scores.items()}


def edges_alone(bag: Path, site: SiteConfig) -> list[Tracks]:
    """Return the tracks that the recorded likelihoods of a bag give by edges alone."""
    assert isinstance(site.fusion, LikelihoodGridConfig)
    config = replace(site.fusion, layers='edges')
    with BagReader(bag) as reader:
        ticks = recorded_ticks(reader, site.camera_names, config)
        return [each.output.tracks for each in drive(config, site.camera_names, ticks)]


def _site(
    folder: Path, settings: dict[str, Any], scenario: IndoorScenario | None = None
) -> SiteConfig:
    """Write the site of the room and read it."""
    scenario = scenario or IndoorScenario()
    write_calibration(scenario, folder)
    cameras = {
        camera.name: {
            'grid': f'{camera.name}.xml',
            'image_width': scenario.width,
            'image_height': scenario.height,
        }
        for camera in INDOOR.cameras(scenario)
    }
    area = f'0,0,{INDOOR.extent_m[0]},{INDOOR.extent_m[1]}'
    content = {'name': 'indoor', 'area': area, 'cameras': cameras} | settings
    (folder / 'indoor.yaml').write_text(yaml.safe_dump(content))
    return load_site(folder / 'indoor.yaml')


def _tracks_of(bag: Path, topic: str, scenario: IndoorScenario) -> Trajectories:
    with BagReader(bag) as reader:
        return _trajectories([rows for rows, _ in reader.rows(topic, Tracks)], scenario)


def _trajectories(tracks: Sequence[Tracks], scenario: IndoorScenario) -> Trajectories:
    """Return what is published of tracks, by the step of the scenario, inside its area."""
    period_ns = round(scenario.period_s * 1e9)
    every = Trajectories.from_tracks(tracks, period_ns, scenario.start_ns)
    inside = ((every.position >= 0) & (every.position <= INDOOR.extent_m)).all(axis=1)
    return every.select(np.asarray(inside))


def _scores(truth: Trajectories, tracks: Trajectories) -> dict[str, float]:
    instants = frames_of(truth, tracks, 'position', ground_distance, GATE_M)
    scores = clear_mot(instants, GATE_M)
    errors = [each.distance[matched(each.distance, GATE_M)] for each in instants]
    targets = max(len(np.unique(truth.id)), 1)
    return {
        'mota': scores['mota'],
        'idf1': scores['idf1'],
        'median_m': float(np.median(np.concatenate([*errors, np.full(1, np.nan)])[:-1])),
        'lost_identities': scores['switches'] / targets,
        'interruptions': scores['fragmentations'] / targets,
    }


def _pooled(runs: Sequence[dict[str, dict[str, float]]]) -> dict[str, float]:
    """Return means over the seeds, and the worst MOTA."""
    figures: dict[str, float] = {}
    for layers in runs[0]:
        for name in runs[0][layers]:
            values = [run[layers][name] for run in runs]
            figures[f'indoor.{layers}.{name}'] = float(np.mean(values))
        figures[f'indoor.{layers}.mota_worst'] = min(run[layers]['mota'] for run in runs)
    return figures


def _light_step(scenario: IndoorScenario, folder: Path) -> dict[str, float]:
    """Return how many tracks are lost when the light changes at once, and the scores."""
    bag, out = folder / 'bag', folder / 'out'
    simulate(scenario, bag, overwrite=True)
    track_bag(bag, out, _site(folder, LIKELIHOOD), overwrite=True)
    tracks = _tracks_of(out / 'bag', '/tracks', scenario)
    truth = _tracks_of(bag, '/truth/tracks', scenario)
    step = round(scenario.step_s * scenario.rate_hz)
    before, after = (
        set(tracks.at_frames([at]).id.tolist())
        for at in (step - 1, step + round(AFTER_S * scenario.rate_hz))
    )
    lost = float(len(before - after))
    return {'step.lost_tracks': lost, 'step.mota': _scores(truth, tracks)['mota']}


def _terrace(data: Path, folder: Path) -> dict[str, float]:
    """Return the scores of the four cameras of the terrace, halves apart."""
    terrace.write_images(data, folder / 'terrace')
    frames = [each for each in image_files(data, CAMERAS[0]) if each >= terrace.FIRST_IMAGE]
    parts = {
        f'to_{terrace.TUNED_TO}': [each for each in frames if each <= terrace.TUNED_TO],
        f'from_{terrace.TUNED_TO + 1}': [each for each in frames if each > terrace.TUNED_TO],
    }
    positions, identities = read_positions(data), read_identities(data, CAMERAS)
    site, out = _terrace_site(data, folder), folder / 'terrace_out'
    track_bag(folder / 'terrace', out, site, overwrite=True)
    tracks = {'both': terrace.read_tracks(out, 0)}
    edges = edges_alone(out / 'bag', site)
    tracks['edges'] = Trajectories.from_tracks(edges, PERIOD_NS, START_NS)
    track_bag(folder / 'terrace', out, terrace.write_site(data, folder), overwrite=True)
    tracks['occupancy'] = terrace.read_tracks(out, 0)
    figures = {}
    for layers, own in tracks.items():
        for part, chosen in parts.items():
            scores = terrace.scored(own, positions, identities, chosen)
            for name in ('gate_half_metre.moda', 'gate_half_metre.modp', 'moda', 'mota', 'idf1'):
                figures[f'terrace.{layers}.{part}.{name}'] = scores[name]
    return figures


def _terrace_site(data: Path, folder: Path) -> SiteConfig:
    """Return the site of the terrace with likelihoods on its annotated area."""
    terrace.write_site(data, folder)
    content = yaml.safe_load((folder / 'site.yaml').read_text())
    (left, right), (low, high) = AREA
    content |= {'area': f'{left},{low},{right},{high}', 'pipeline': LIKELIHOOD['pipeline']}
    content['fusion'] |= LIKELIHOOD['fusion']
    (folder / 'terrace.yaml').write_text(yaml.safe_dump(content))
    return load_site(folder / 'terrace.yaml')


def _protocol(rooms: Sequence[IndoorScenario]) -> dict[str, Any]:
    scenario = rooms[0]
    return {
        'indoor scene': f'{scenario.steps} images of each of four cameras, {scenario.width} x '
        f'{scenario.height} px, {scenario.rate_hz:g} a second, the first {EMPTY_STEPS} without '
        f'people; truth inside 6 x 4.2 m; gate {GATE_M} m',
        'seeds and people': ', '.join(f'{room.seed}: {room.people}' for room in rooms)
        + ' (constants were chosen on seeds 1, 2 and 4)',
        'paper': f'edges alone, local maxima of the product, Algorithm 1; the background of '
        f'{LEARNING_IMAGES} images without people',
        'edges': 'the same, with edges of the background that the first pass found, from the '
        'likelihoods that the run by both recorded',
        'shapes': 'a cylinder, and others: '
        + ', '.join(f'edges_{shape}, both_{shape}' for shape in OTHER_SHAPES),
        'cameras': f'by both, of the first seed, with {", ".join(map(str, OTHER_CAMERAS))}; truth '
        'is who is in the area, seen or not',
        'occupancy': 'fusion.tracker occupancy, cameras by default',
        'both': 'fusion.tracker likelihood_grid: masks, edges and colours, Algorithm 1',
        'lost identities, interruptions': 'switches and fragmentations a target',
        'light step': f'{LIGHT_STEP:.0%} brighter at once; lost: published just before, and no '
        f'more {AFTER_S:g} s later',
        'terrace': f'as terrace4: constants were chosen on frames to {terrace.TUNED_TO}; the '
        'likelihood grid is given the annotated area',
        'speed': 'four-camera sets a second of processor time on one core, cameras and fusion; '
        'images: decoded, 752 x 480 px; edge maps: their oriented distance and all after it',
    }
