"""What the worst tick of bad input costs, what of it is counted, and whether tracking goes on."""

from __future__ import annotations

import gc
import resource
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.bench.fusion.adapter import (
    Reported,
    camera_names,
    messages_of,
    reported,
    stamp_of,
    told_config,
)
from mctrack_experiments.bench.fusion.hostile_input import SPOILERS, Messages
from mctrack_experiments.bench.fusion.toolkit import Toolkit
from mctrack_experiments.bench.workers import Progress, run_pinned, silent
from mctrack_ros.fusion import JointTracker, open_batcher

BEFORE, SPOILED, AFTER = 75, 25, 75
"""Ticks that are good, that are spoiled, and that are good again."""

SETTLED = 50
"""Of the last ones, those over which it is scored how tracking goes on."""

MEMORY_BYTES = 6 * 2**30
LONGEST_S = 20
"""What takes more memory or processor time has failed."""

NOBODY: Reported = ([], np.zeros((0, 2)))
SEED = 1


@dataclass(frozen=True, slots=True)
class Endured:
    """
    What became of one kind of bad input.

    Attributes
    ----------
    worst_ms : float
        Longest processor time of a tick from the first spoiled one on, ms; NaN: it failed.
    refused : int
        Messages and detections that were not used, as counted.
    mota_after : float
        MOTA at 1 m over the last ticks; NaN: it failed.
    failure : str
        What it died of; empty: nothing.

    """

    worst_ms: float
    refused: int
    mota_after: float
    failure: str = ''


class Listener:
    """
    Batcher and pipeline, as the fusion node runs them.

    Parameters
    ----------
    scenario : Scenario of the benchmark
        Its cameras and what is told about them.

    """

    def __init__(self, scenario: Any) -> None:
        config, cameras = told_config(scenario), camera_names(scenario)
        self._batcher = open_batcher(config, cameras)
        self._pipeline = JointTracker(config, cameras)
        self._period_ns = round(config.batching.period * 1e9)
        self.refused = 0

    def hear(self, messages: Messages, stamp_ns: int) -> Reported:
        """Take what the cameras send within a period, and fuse it."""
        ticks = []
        for message in messages:
            try:
                ticks += self._batcher.add(message.camera, message.rows, stamp_ns)
            except ValueError:
                self.refused += 1
        ticks += self._batcher.poll(stamp_ns + self._period_ns)
        latest = NOBODY
        for tick in ticks:
            record = tick.record
            self.refused += int(record.late.sum() + record.dropped_detections.sum())
            latest = reported(self._pipeline.step(tick).tracks)
        return latest


def measure_hostile(folder: Path, progress: Progress = silent) -> tuple[dict[str, float], str]:
    """
    Try every kind of bad input.

    Parameters
    ----------
    folder : Path
        Of the benchmark.
    progress : callable
        Told how many kinds are done.

    Returns
    -------
    figures : dict of str to float
    failures : str
        What died of what; empty: nothing did.

    """
    outcomes = run_pinned(_tried, [(folder, name) for name in SPOILERS], progress)
    figures = {'hostile.worst_ms': float(np.max([each.worst_ms for each in outcomes]))}
    failures = []
    for name, each in zip(SPOILERS, outcomes):
        figures |= {
            f'hostile.{name}_ms': each.worst_ms,
            f'hostile.{name}.refused': each.refused,
            f'hostile.{name}.mota_after': each.mota_after,
        }
        if each.failure:
            failures.append(f'{name}: {each.failure}')
    return figures, '; '.join(failures)


def _tried(job: tuple[Path, str]) -> Endured:
    """Run one kind of bad input within limits; whatever it dies of is the outcome."""
    folder, name = job
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    signal.signal(signal.SIGPROF, _give_up)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        return endured(Toolkit(folder), name)
    except Exception as error:
        return Endured(np.nan, 0, np.nan, repr(error.__cause__ or error))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _give_up(*_: object) -> None:
    raise TimeoutError(f'more than {LONGEST_S} s of processor time')


def endured(toolkit: Toolkit, name: str) -> Endured:
    """Return what becomes of one kind of bad input."""
    frames = BEFORE + SPOILED + AFTER
    scene = toolkit.scene(frames, SEED)
    scenario, rng = scene.scenario, np.random.default_rng(SEED)
    listener = Listener(scenario)
    milliseconds: list[float] = []
    told: list[Reported] = []
    gc.collect()
    gc.freeze()  # what was there before the first message is left alone, as in a node's process
    for frame in range(frames):
        messages = messages_of(scenario, frame)
        if BEFORE <= frame < BEFORE + SPOILED:
            messages = SPOILERS[name](messages, frame - BEFORE, rng)
        began = time.thread_time()
        told.append(listener.hear(messages, stamp_of(scenario, frame)))
        milliseconds.append((time.thread_time() - began) * 1e3)
    mota = toolkit.score(scene, told, skip=frames - SETTLED).mota
    return Endured(max(milliseconds[BEFORE:]), listener.refused, float(mota))
