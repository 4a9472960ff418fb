"""Time of a core tick beside other trackers, in turns within one process on one core."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.bench.fusion.adapter import CoreTracker
from mctrack_experiments.bench.fusion.toolkit import SLOW_PEERS, WARM_UP, Toolkit
from mctrack_experiments.bench.workers import Progress, run_pinned, silent

OURS = 'fusion'
SMALLER = 'smaller'
QUICK_SHARE = 0.4
SEED = 1


@dataclass(frozen=True, slots=True)
class SpeedRun:
    """
    One scene on which trackers take turns.

    Attributes
    ----------
    name : str
        Of its figures.
    scene : mapping of str to float
        Parameters of the scene.
    frames : int
        Ticks that are run.
    peers : tuple of str
        Trackers beside our own.
    smaller : mapping of str to float
        A smaller scene on which our own takes turns with itself; empty: none.

    """

    name: str
    scene: Mapping[str, float]
    frames: int
    peers: tuple[str, ...]
    smaller: Mapping[str, float] = field(default_factory=dict)


HUNDRED = {'targets': 100}
THOUSAND = {'targets': 1000}
NORFAIR = ('norfair',)
RUNS = (
    SpeedRun('t25c5', {}, 525, NORFAIR),
    SpeedRun('t25c5', {}, 85, SLOW_PEERS),
    SpeedRun('t100c5', HUNDRED, 325, NORFAIR),
    SpeedRun('t1000c5', THOUSAND, 105, NORFAIR, HUNDRED),
    SpeedRun('t1000c20_cov3', THOUSAND | {'cameras': 20, 'coverage': 0.15}, 105, NORFAIR),
    SpeedRun('t1000c20', THOUSAND | {'cameras': 20}, 85, NORFAIR),
)


class Clocked:
    """
    A tracker whose processor time is noted: what the machine does meanwhile does not count.

    Parameters
    ----------
    tracker : Tracker of the benchmark
        What is timed.

    Attributes
    ----------
    milliseconds : list of float
        Processor time of each tick, ms.

    """

    def __init__(self, tracker: Any) -> None:
        self.prepare = tracker.prepare
        self._step = tracker.step
        self.milliseconds: list[float] = []

    def step(self, frame: int) -> Any:
        """Process a tick."""
        began = time.thread_time()
        told = self._step(frame)
        self.milliseconds.append((time.thread_time() - began) * 1e3)
        return told


def measure_speed(
    folder: Path, peers: Sequence[str], *, quick: bool = False, progress: Progress = silent
) -> dict[str, float]:
    """
    Time all scenes.

    Parameters
    ----------
    folder : Path
        Of the benchmark.
    peers : sequence of str
        Other trackers to be run beside.
    quick : bool
        Run fewer ticks, and no slow trackers.
    progress : callable
        Told how many of the scenes are done.

    """
    figures: dict[str, float] = {}
    jobs = [(folder, run) for run in chosen_runs(peers, quick)]
    for one in run_pinned(measured, jobs, progress):
        figures = one | figures
    return dict(sorted(figures.items()))


def chosen_runs(peers: Sequence[str], quick: bool) -> list[SpeedRun]:
    """Return the runs with those peers alone; none that would only repeat another."""
    chosen: list[SpeedRun] = []
    for run in RUNS:
        beside = tuple(p for p in run.peers if p in peers and not (quick and p in SLOW_PEERS))
        frames = round(run.frames * QUICK_SHARE) if quick else run.frames
        if beside or run.name not in {each.name for each in chosen}:
            chosen.append(replace(run, peers=beside, frames=frames))
    return chosen


def measured(job: tuple[Path, SpeedRun]) -> dict[str, float]:
    """Return the figures of one run with the benchmark of a folder."""
    folder, run = job
    toolkit = Toolkit(folder)
    scene = toolkit.scene(run.frames, SEED, **run.scene)
    trackers = {OURS: Clocked(CoreTracker(scene.scenario))}
    if run.smaller:
        smaller = toolkit.scene(run.frames, SEED, **run.smaller)
        trackers[SMALLER] = Clocked(CoreTracker(smaller.scenario))
    trackers |= {peer: Clocked(toolkit.peer(peer, scene)) for peer in run.peers}
    told = toolkit.measure(trackers, run.frames)
    wall = {name: each.milliseconds for name, each in told.items()}
    processor = {name: each.milliseconds for name, each in trackers.items()}
    return figures_of(run.name, wall) | figures_of(f'{run.name}.cpu', processor)


def figures_of(name: str, milliseconds: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """
    Return median and 99th percentile of each tracker's ticks and the ratios to ours.

    Parameters
    ----------
    name : str
        First part of the figures' names.
    milliseconds : mapping of str to sequence of float
        Time of each tick by tracker, ms; ours is ``fusion``.

    """
    figures: dict[str, float] = {}
    for tracker, spent in milliseconds.items():
        label = '' if tracker == OURS else tracker.replace('-', '_') + '_'
        counted = spent[min(WARM_UP, len(spent) // 3) :]
        median, slow = np.quantile(counted, (0.5, 0.99)).tolist()
        figures |= {f'{name}.{label}p50_ms': median, f'{name}.{label}p99_ms': slow}
        if tracker == SMALLER:
            figures[f'{name}.growth'] = figures[f'{name}.p50_ms'] / median
        elif tracker != OURS:
            figures[f'{name}.{label}ratio'] = median / figures[f'{name}.p50_ms']
    return figures
