"""Time of a whole tick: messages in, groups, identity, looks, feedback, messages out."""

from __future__ import annotations

import time
from collections import defaultdict, deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from mctrack_experiments.bench.fusion.adapter import (
    Reported,
    camera_names,
    reported,
    stamp_of,
    told_config,
)
from mctrack_experiments.bench.fusion.synthetic_cameras import SyntheticCameras
from mctrack_experiments.bench.fusion.toolkit import WARM_UP, Scene, Toolkit
from mctrack_experiments.bench.workers import Progress, run_pinned, silent
from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.fusion import JointTracker, open_batcher
from mctrack_ros.interfaces import Detections, Feedback
from mctrack_ros.recording import ROSBAGS_CLASSES

FRAMES, QUICK_FRAMES = 525, 225
SEED = 1
FEEDBACK_DELAY = 2
"""Ticks after which feedback is at the cameras."""

GROUND_FRAME = 'map'
STAGES = ('decoding', 'batching', 'fusion', 'encoding')
WHOLE = ('fusion', 'encoding')
"""What the whole tick is; decoding and batching spread over the period as messages come in."""


class WholeTracker:
    """
    What the fusion node does with the messages of a tick.

    Parameters
    ----------
    scene : Scene
        The scene.

    Attributes
    ----------
    milliseconds : dict of str to list of float
        Time of each tick by stage, ms.

    """

    def __init__(self, scene: Scene) -> None:
        config, cameras = told_config(scene.scenario), camera_names(scene.scenario)
        self._scenario = scene.scenario
        self._cameras = SyntheticCameras(scene, SEED)
        self._batcher = open_batcher(config, cameras)
        self._pipeline = JointTracker(config, cameras)
        self._feedback = deque([Feedback.build(0)] * FEEDBACK_DELAY, FEEDBACK_DELAY)
        self.milliseconds: dict[str, list[float]] = defaultdict(list)

    def prepare(self, frame: int) -> None:
        """Let the cameras send their messages; not timed."""
        self._messages = [
            (each.camera, cloud_from_rows(each.rows, ROSBAGS_CLASSES, GROUND_FRAME))
            for each in self._cameras.messages(frame, self._feedback[0])
        ]

    def step(self, frame: int) -> Reported:
        """Process a tick, stage by stage."""
        stamp_ns = stamp_of(self._scenario, frame)
        with self._timed('decoding'):
            decoded = [(name, rows_from_cloud(one, Detections)) for name, one in self._messages]
        with self._timed('batching'):
            ticks = [
                tick
                for name, detections in decoded
                for tick in self._batcher.add(name, detections, stamp_ns)
            ]
        with self._timed('fusion'):
            (output,) = [self._pipeline.step(tick) for tick in ticks]
            feedback = self._pipeline.feedback()
        with self._timed('encoding'):
            for rows in (output.tracks, feedback, output.events, ticks[0].record):
                cloud_from_rows(rows, ROSBAGS_CLASSES, GROUND_FRAME)
        self._feedback.append(feedback)
        return reported(output.tracks)

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.milliseconds[stage].append((time.perf_counter() - began) * 1e3)


def measure_whole(
    folder: Path, *, quick: bool = False, progress: Progress = silent
) -> dict[str, float]:
    """
    Time whole ticks of 25 targets and 5 cameras.

    Parameters
    ----------
    folder : Path
        Of the benchmark.
    quick : bool
        Run fewer ticks.
    progress : callable
        Told whether it is done.

    """
    job = folder, QUICK_FRAMES if quick else FRAMES
    return run_pinned(_measured, [job], progress)[0]


def _measured(job: tuple[Path, int]) -> dict[str, float]:
    folder, frames = job
    toolkit = Toolkit(folder)
    scene = toolkit.scene(frames, SEED)
    tracker = WholeTracker(scene)
    measured = toolkit.measure({'fusion': tracker}, frames)['fusion']
    spent = {stage: np.array(tracker.milliseconds[stage])[WARM_UP:] for stage in STAGES}
    whole = sum(spent[stage] for stage in WHOLE)
    median, slow = np.quantile(whole, (0.5, 0.99)).tolist()
    score = toolkit.score(scene, measured.reported)
    return {
        'whole.p50_ms': median,
        'whole.p99_ms': slow,
        **{f'whole.{stage}_ms': float(np.median(each)) for stage, each in spent.items()},
        'whole.idf1': float(score.idf1),
    }
