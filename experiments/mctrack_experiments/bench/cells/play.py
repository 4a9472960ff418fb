"""A site in lock step: through its cells and their fusion, and through one fusion node alone."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mctrack_experiments.bench.cells.site import TICK_S, CellSite
from mctrack_experiments.bench.fusion.adapter import camera_names, stamp_of
from mctrack_experiments.bench.fusion.synthetic_cameras import SyntheticCameras
from mctrack_experiments.scenarios.rooms import PERSONAL
from mctrack_experiments.scenarios.staged.playing import FEEDBACK_DELAY, TEMPLATE_PIXELS
from mctrack_ros.fusion import FusionConfig, FusionTracker, JointConfig, open_batcher, open_fusion
from mctrack_ros.fusion.cells.config import CellsConfig
from mctrack_ros.fusion.cells.report import CellReport
from mctrack_ros.interfaces import CameraDetections, Feedback, RowsTick, Tick, Tracks

JOINED = 25
"""One fusion node takes 32 cameras at most: here four that are far apart count as one, each."""
IMAGE_PX = 100_000.0
"""From the image of one of these to that of the next, px: they have nothing in common."""
IDS = 10_000_000
"""The local ids of a cell begin so far behind those of the one before."""
DELAY_MS, JITTER_MS = (20.0, 120.0), 40.0
"""How late a cell's reports are at the site, and by how much that changes, ms."""


@dataclass
class Process:
    """
    A tracker, what it published, and the processor time that its ticks took.

    Attributes
    ----------
    tracks : list of Tracks
        One a tick.
    milliseconds : list of float
        One a tick.

    """

    tracker: FusionTracker
    tracks: list[Tracks] = field(default_factory=list)
    milliseconds: list[float] = field(default_factory=list)
    on_its_way: deque[Feedback] = field(
        default_factory=lambda: deque([Feedback.build(0)] * FEEDBACK_DELAY, FEEDBACK_DELAY)
    )

    def step(self, tick: RowsTick[Any]) -> Feedback:
        """Process a tick; return the feedback on it."""
        began = time.thread_time()
        output = self.tracker.step(tick)
        feedback = self.tracker.feedback()
        self.milliseconds.append((time.thread_time() - began) * 1e3)
        self.tracks.append(output.tracks)
        assert isinstance(feedback, Feedback)
        self.on_its_way.append(feedback)
        return feedback


@dataclass(frozen=True, eq=False, slots=True)
class Arrival:
    """A report of a cell on its arrival at the site, ns."""

    arrival_ns: int
    cell: int
    report: CellReport


def play_cells(
    site: CellSite,
    seed: int,
    hear: Callable[[int, CameraDetections], None] = lambda cell, message: None,
) -> tuple[list[Process], list[Arrival]]:
    """
    Let cells track; return their processes, and what arrives at the site, in order.

    Every second cell has half the others' rate; what they publish arrives late. Told is, cell by
    cell, what the cameras of each tell.
    """
    rng = np.random.default_rng([seed, 53])
    arrivals, processes = [], []
    for cell, scene in enumerate(site.scenes):
        cameras = _cameras(site, cell, seed)
        process = _process(JointConfig(), camera_names(scene.scenario))
        delay_ms = rng.uniform(*DELAY_MS)
        for frame in range(0, len(site.paths), 1 + cell % 2):
            messages = cameras.messages(frame, process.on_its_way[0])
            for message in messages:
                hear(cell, message)
            feedback = process.step(Tick.of(messages))
            late_ns = round((delay_ms + rng.uniform(0, JITTER_MS)) * 1e6)
            report = CellReport(process.tracks[-1], feedback)
            arrivals.append(Arrival(report.stamp_ns + late_ns, cell, report))
        processes.append(process)
    return processes, sorted(arrivals, key=lambda each: (each.arrival_ns, each.cell))


def play_site(arrivals: Sequence[Arrival], cells: int, tick_s: float = TICK_S) -> Process:
    """Let the fusion of cells track what they report, at ticks so far from each other, s."""
    names, config = tuple(f'cell{cell}' for cell in range(cells)), timed(CellsConfig(), tick_s)
    fused, batcher = Process(open_fusion(config, names)), open_batcher(config, names)
    for each in arrivals:
        now_ns = each.arrival_ns
        for tick in batcher.add(names[each.cell], each.report, now_ns, now_ns):
            fused.step(tick)
    for tick in batcher.flush():
        fused.step(tick)
    return fused


def play_one(site: CellSite, seed: int) -> Process:
    """Let one fusion node track all, with the same cameras' detections at their full rate."""
    cells = [_cameras(site, cell, seed) for cell in range(len(site.scenes))]
    process = _process(JointConfig(), tuple(f'cam{index:02}' for index in range(JOINED)))
    places = [scene.fields['camera_position'] for scene in site.scenes]
    order = np.lexsort(np.concatenate(places).T)
    joined = np.empty(len(order), np.intp)
    joined[order] = np.arange(len(order)) % 5 + 5 * (np.arange(len(order)) // 10 % 5)
    for frame in range(len(site.paths)):
        told = [
            _offset(message, cell)
            for cell, cameras in enumerate(cells)
            for message in cameras.messages(frame, process.on_its_way[0])
        ]
        process.step(_joined(told, joined, stamp_of(site.scenes[0].scenario, frame)))
    return process


def timed(config: FusionConfig, tick_s: float = TICK_S) -> FusionConfig:
    """Return parameters with ticks so far from each other, s."""
    return replace(config, batching=replace(config.batching, period=tick_s))


def _process(config: FusionConfig, names: tuple[str, ...]) -> Process:
    return Process(open_fusion(timed(config), names))


def _cameras(site: CellSite, cell: int, seed: int) -> SyntheticCameras:
    return SyntheticCameras(site.scenes[cell], seed, site.kit, PERSONAL, TEMPLATE_PIXELS)


def _offset(message: CameraDetections, cell: int) -> CameraDetections:
    """Let local ids of different cells differ."""
    rows = message.rows
    local_id = np.where(rows.local_id > 0, rows.local_id + np.uint32(IDS * cell), 0)
    return CameraDetections(message.camera, rows.replace(local_id=local_id))


def _joined(messages: Sequence[CameraDetections], joined: Any, stamp_ns: int) -> Tick:
    """Join the messages of cameras that count as one, side by side in one wide image."""
    images = []
    for index in range(JOINED):
        parts = [messages[camera].rows for camera in np.flatnonzero(joined == index).tolist()]
        apart = [
            rows.replace(box=rows.box + np.array([IMAGE_PX * place, 0, 0, 0], np.float32))
            for place, rows in enumerate(parts)
        ]
        rows = type(parts[0]).joined(stamp_ns, apart)
        images.append(CameraDetections(f'cam{index:02}', rows))
    return Tick.of(images)
