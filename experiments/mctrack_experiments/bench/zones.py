"""What zone events cost a tick, and how right crossings of lines are counted."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.adapter import camera_names, stamp_of, told_config
from mctrack_experiments.bench.fusion.synthetic_cameras import SyntheticCameras
from mctrack_experiments.bench.fusion.toolkit import Toolkit
from mctrack_experiments.bench.workers import Progress, run_pinned, run_spread
from mctrack_experiments.runs import listed
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import FusionOutput
from mctrack_ros.interfaces import Events, Feedback, Tick, Tracks
from mctrack_ros.replay.drive import drive
from mctrack_ros.zones.engine import ZoneEngine
from mctrack_ros.zones.shapes import Line, Zone, Zones

TRACKS, ZONES, CORNERS, LINES, RATE_HZ = 25, 10, 8, 4, 25
TICKS, WARM_UP = 2500, 25
FRAMES = 3000
SIDES_M = np.array([105.0, 68.0])
FEEDBACK_DELAY = 2
"""Ticks after which feedback is at the cameras."""
COUNTED = (
    Line('x 52.5', ((52.5, -50.0), (52.5, 118.0))),
    Line('x 20', ((20.0, -50.0), (20.0, 118.0))),
    Line('y 34', ((-50.0, 34.0), (155.0, 34.0))),
    Line('y 20', ((-50.0, 20.0), (155.0, 20.0))),
)
"""Lines through the whole field: nobody walks around them."""
AT_ONCE = 0.5 + 1e-6
"""Probability of a side from which it counts without hysteresis."""

Floats = NDArray[np.float64]
Counts = tuple[int, int, int]


def bench_zones(
    folder: Path, seeds: Sequence[int], show: Callable[[str], AbstractContextManager[Progress]]
) -> Figures:
    """
    Time the zone engine, and count who crosses lines on scenes whose truth is known.

    Parameters
    ----------
    folder : Path
        Of the fusion benchmark, whose scenes these are.
    seeds : sequence of int
        One scene for each.
    show : callable
        Makes a progress bar of a title.

    """
    with show('engine') as progress:
        ((median, p99),) = run_pinned(_timed, [1], progress)
    with show('crossings, scenes') as progress:
        counts = run_spread(_counted, [(folder, seed) for seed in seeds], progress)
    true, counted, raw = np.concatenate(counts).T
    return Figures(
        'bench_zones',
        'mctrack bench zones',
        {
            'tick': f'{TRACKS} tracks, {ZONES} zones of {CORNERS} corners, {LINES} lines; '
            'processor time of a tick',
            'scenes': f'seeds {listed(seeds)}: {FRAMES} ticks of 25 people before five cameras, '
            f'{len(COUNTED)} lines',
            'wrong_share': 'differences between counted and true crossings of each line and '
            'scene, added, over all true ones; every change of side of a true path counts',
            'raw': 'the same without hysteresis: every change of side of a track counts',
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
        },
        {
            'tick.p50_ms': median,
            'tick.p99_ms': p99,
            'crossings.true': float(true.sum()),
            'crossings.counted': float(counted.sum()),
            'crossings.raw': float(raw.sum()),
            'crossings.wrong_share': float(np.abs(counted - true).sum() / true.sum()),
            'crossings.raw_wrong_share': float(np.abs(raw - true).sum() / true.sum()),
        },
    )


def _timed(seed: int) -> tuple[float, float]:
    """Return median and 99th percentile of the engine's processor time a tick, ms."""
    random = np.random.default_rng(seed)
    engine = ZoneEngine(_drawn(random))
    place, speed = random.uniform(0, SIDES_M, (TRACKS, 2)), random.normal(0, 3, (TRACKS, 2))
    covariance = np.tile(np.diag([0.04, 0.04, 0.25, 0.25]), (TRACKS, 1, 1))
    times = []
    for tick in range(TICKS):
        speed += random.normal(0, 0.3, speed.shape)
        speed = np.where((place < 0) | (place > SIDES_M), np.sign(SIDES_M / 2 - place), speed)
        place = place + speed / RATE_HZ
        rows = Tracks.build(
            (tick + 1) * 1_000_000_000 // RATE_HZ,
            position=np.pad(place, ((0, 0), (0, 1))),
            covariance=covariance,
            track_id=np.arange(1, TRACKS + 1),
        )
        events = Events.build(rows.stamp_ns)
        began = time.thread_time()
        engine.added(rows, events)
        times.append((time.thread_time() - began) * 1e3)
    return float(np.median(times[WARM_UP:])), float(np.quantile(times[WARM_UP:], 0.99))


def _drawn(random: np.random.Generator) -> Zones:
    """Return zones around random middles, and lines between random points."""
    zones = []
    for number in range(ZONES):
        middle, angles = random.uniform(0, SIDES_M), np.sort(random.uniform(0, 2 * np.pi, CORNERS))
        corners = middle + 10.0 * np.column_stack([np.cos(angles), np.sin(angles)])
        zones.append(Zone(f'zone {number}', tuple(map(tuple, corners.tolist())), 5.0, 2))
    ends = random.uniform(0, SIDES_M, (LINES, 2, 2)).tolist()
    lines = [Line(f'line {k}', tuple(map(tuple, points))) for k, points in enumerate(ends)]
    return Zones(tuple(zones), tuple(lines))


def _counted(job: tuple[Path, int]) -> NDArray[np.int64]:
    """Return true, counted and raw crossings of each line in a scene, (lines, 3)."""
    folder, seed = job
    truth, outputs = _tracked(folder, seed)
    return np.array([_crossings(truth, outputs, line) for line in COUNTED])


def _tracked(folder: Path, seed: int) -> tuple[Floats, list[FusionOutput]]:
    """Return true positions, (ticks, people, 2), and what fusion makes of a scene."""
    scene = Toolkit(folder).scene(FRAMES, seed)
    cameras = SyntheticCameras(scene, seed)
    config, names = told_config(scene.scenario), camera_names(scene.scenario)
    on_its_way = deque([Feedback.build(0)] * FEEDBACK_DELAY, FEEDBACK_DELAY)
    ticks = (Tick.of(cameras.messages(frame, on_its_way[0])) for frame in range(FRAMES))
    outputs = []
    for ticked in drive(config, names, ticks):
        outputs.append(ticked.output)
        assert isinstance(ticked.feedback, Feedback)
        on_its_way.append(ticked.feedback)
    assert outputs[-1].tracks.stamp_ns == stamp_of(scene.scenario, FRAMES - 1)
    return scene.scenario.truth, outputs


def _crossings(truth: Floats, outputs: Sequence[FusionOutput], line: Line) -> Counts:
    """Return true, counted and raw crossings of a line that is parallel to an axis."""
    (x, y), (end_x, _) = line.points
    side = truth[..., 0] > x if x == end_x else truth[..., 1] > y
    counts = [
        sum(len(engine.step(each.tracks, each.events)) for each in outputs)
        for engine in (
            ZoneEngine(Zones(lines=(line,))),
            ZoneEngine(Zones(lines=(replace(line, probability=AT_ONCE),))),
        )
    ]
    return int((side[1:] != side[:-1]).sum()), counts[0], counts[1]
