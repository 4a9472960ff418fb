"""The covering-graph paper's Table I, two sensors over one, and greedy against optimal."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from mctrack_experiments.bench.workers import run_spread
from mctrack_experiments.papers.covering import scenes
from mctrack_experiments.papers.covering.assignment import (
    BestPerSensor,
    compared,
    recorded,
    replaced,
    timed_association,
)
from mctrack_experiments.papers.covering.code_cost import as_in_the_code
from mctrack_experiments.papers.covering.protocol import protocol
from mctrack_experiments.papers.covering.scenes import CoveringScene
from mctrack_experiments.papers.covering.trackers import NAMES, PROPOSED, config_of, run
from mctrack_experiments.real.continuity import isolated_breaks
from mctrack_ros.evaluation import evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import JointTracker

PITCHES = 3
"""So many of the seeds are of pitches, the others of car parks."""
FIRST, BESIDE, FACING = ('cam1',), ('cam1', 'cam3'), ('cam1', 'cam2')
"""Cameras of the pitch: one; with the next along the touch line; with the one opposite."""
BREAK_S = 1.5
COUNTED = ('switches', 'ids', 'isolated_breaks', 'ticks', 'images', 'contested', 'worse', 'late',
           'proposals', 'bound')  # fmt: skip
"""Figures that are added up over recordings; of others the mean is taken."""

Measured = Mapping[str, float]
Job = tuple[str, int, Path]


def reproduce_covering(
    data: Path,
    seeds: Sequence[int],
    progress: Callable[[str], None] = lambda line: None,
) -> Figures:
    """
    Compare trackers on the same detections of simulated and real cameras.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    seeds : sequence of int
        One recording each: `PITCHES` matches, then recordings of the car park.
    progress : callable
        Told what is done.

    """
    pitches, carparks = seeds[:PITCHES], seeds[PITCHES:]
    jobs: list[Job] = [('pitch', seed, data) for seed in pitches]
    jobs += [(name, 0, data) for name in ('terrace', 'lab6p', 'pets')]
    jobs += [('carpark', seed, data) for seed in carparks]

    def tell(done: int, total: int) -> None:
        progress(f'{done} of {total} recordings are measured')

    figures = averaged(run_spread(measured, jobs, tell))
    for name in NAMES:
        for pair in ('beside', 'facing'):
            two, one = (f'{pair}.{count}.{name}.mota' for count in ('two', 'one'))
            figures[f'{pair}.gain.{name}'] = figures[two] - figures[one]
    return Figures('covering', 'mctrack reproduce covering', protocol(pitches, carparks), figures)


def measured(job: Job) -> Measured:
    """Make one recording's detections and run everything on them."""
    kind, seed, data = job
    if kind == 'pitch':
        return pitch_figures(seed)
    scene = {
        'carpark': partial(scenes.carpark, seed),
        'pets': partial(scenes.pets, data),
        'terrace': partial(scenes.terrace_clips, data),
        'lab6p': partial(scenes.lab6p, data),
    }[kind]()
    cameras = scene.stored.cameras
    table = continuity if kind == 'terrace' else scored
    figures = dict(table(kind, scene, cameras))
    if len(cameras) > 1:
        figures |= assignment(kind, scene, cameras)
    return figures


def pitch_figures(seed: int, seconds: float = scenes.PITCH_S) -> Measured:
    """Run everything on one match: with one camera, and with two in two ways."""
    scene = scenes.pitch(seed, ('cam1', 'cam2', 'cam3'), seconds)
    figures = dict(scored('pitch', scene, FIRST))
    for pair, cameras in (('beside', BESIDE), ('facing', FACING)):
        figures |= scored(f'{pair}.two', scene, cameras)
        figures |= scored(f'{pair}.one', scene, FIRST, cameras)
        figures |= assignment(pair, scene, cameras)
    return figures


def scored(
    label: str, scene: CoveringScene, cameras: tuple[str, ...], area: tuple[str, ...] = ()
) -> Measured:
    """Return Table I's row of a recording; the area is that of other cameras, if named."""
    figures: dict[str, float] = {}
    truth = scene.truth(area or cameras)
    for name in NAMES:
        tracks = scene.scored(run(name, scene, cameras), area or cameras)
        scores = evaluate_ground(truth, tracks, scene.gate_m)
        figures |= {
            f'{label}.{name}.mota': scores.mota,
            f'{label}.{name}.motp': scores.motp,
            f'{label}.{name}.idf1': scores.idf1,
            f'{label}.{name}.error_m': scores.mean_distance,
            f'{label}.{name}.switches': scores.switches,
        }
    return figures


def continuity(label: str, scene: CoveringScene, cameras: tuple[str, ...]) -> Measured:
    """Return what can be said of tracks without truth."""
    figures: dict[str, float] = {}
    frames, rate = scene.frames, scene.stored.rate
    for name in NAMES:
        tracks = run(name, scene, cameras)
        count = np.bincount(tracks.frame, minlength=len(frames))
        figures |= {
            f'{label}.{name}.ids': len(np.unique(tracks.id)),
            f'{label}.{name}.people_mean': float(count.mean()),
            f'{label}.{name}.count_changes_per_minute': float(
                np.count_nonzero(np.diff(count)) / (len(frames) / rate / 60)
            ),
            f'{label}.{name}.isolated_breaks': isolated_breaks(tracks, round(BREAK_S * rate)),
        }
    return figures


def assignment(label: str, scene: CoveringScene, cameras: tuple[str, ...]) -> Measured:
    """Return what the greedy exchange costs beside the optimum, and what share of a tick."""
    figures: dict[str, float] = {}
    for name in PROPOSED:
        pipeline = JointTracker(config_of(name, scene.fusion), cameras)
        with (
            recorded() as kept,
            as_in_the_code(name == 'covering_code'),
            timed_association() as own,
        ):
            given = list(scene.stored.ticks(cameras))
            began = time.process_time()
            for tick in given:
                pipeline.step(tick)
            fusion_us = 1e6 * (time.process_time() - began) / len(given)
        values = asdict(compared(kept, name))
        share = len(cameras) / len(scene.stored.cameras)
        whole_us = fusion_us + 1e3 * share * scene.camera_ms
        values |= {'association_us': 1e6 * own.spent_s / len(given), 'fusion_us': fusion_us}
        values['proposals_of_bound'] = values['proposals'] / max(values['bound'], 1)
        if scene.camera_ms:
            for part in ('greedy', 'association', 'fusion'):
                values[f'{part}_share_of_tick'] = values[f'{part}_us'] / whole_us
        figures |= {f'assignment.{label}.{name}.{key}': each for key, each in values.items()}
    if len(scene.stored.truth):
        with replaced(BestPerSensor):
            tracks = scene.scored(run('covering_text', scene, cameras), cameras)
        scores = evaluate_ground(scene.truth(cameras), tracks, scene.gate_m)
        figures[f'assignment.{label}.optimal.mota'] = scores.mota
        figures[f'assignment.{label}.optimal.idf1'] = scores.idf1
    return figures


def averaged(recordings: Iterable[Measured]) -> dict[str, float]:
    """Return the figures of all recordings together."""
    values: dict[str, list[float]] = defaultdict(list)
    for each in recordings:
        for name, value in each.items():
            values[name].append(value)
    return {name: together(name, each) for name, each in values.items()}


def together(name: str, values: Sequence[float]) -> float:
    """Return what a figure is over all recordings."""
    last = name.rsplit('.', 1)[-1]
    if last in COUNTED:
        return sum(values)
    return max(values) if last == 'largest_ratio' else float(np.mean(values))
