"""The site of a hundred cameras live: each cell a fusion node, the site another, over DDS."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mctrack_experiments.bench.cells.bench import (
    BORDERS,
    LATE_S,
    LONG_S,
    crossings_of,
    ids_of,
    is_kept,
)
from mctrack_experiments.bench.cells.play import play_cells
from mctrack_experiments.bench.cells.site import GRID, PEOPLE, SECONDS, TICK_S, CellSite, cell_site
from mctrack_experiments.bench.fusion.adapter import camera_names
from mctrack_ros.cli.live import prepare_nodes
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import CameraDetections, Detections, Tracks
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec, player_node, recorder_node
from mctrack_ros.ros.graph.supervise import Process, Supervisor

START_NS = 1_700_000_000 * 10**9
"""Stamp at which the scene begins in the bag."""
BEGIN = '/begin'
"""Topic of one message with the stamp at which the scene begins as it is played."""
_SAMPLE_S = 0.5
_MEASURED_S = 0.8 * SECONDS
"""Of the scene, at its end: the nodes have started by then."""
_TICKS_S = os.sysconf('SC_CLK_TCK')


def bench_cells_live(
    cells: int = 4,
    seed: int = 1001,
    every: int = 2,
    progress: Callable[[str], None] = lambda line: None,
) -> Figures:
    """
    Play what a hundred cameras detect into the nodes of the cells and of the site.

    Parameters
    ----------
    cells : int
        How many: 4, 6 or 8.
    seed : int
        Of the site.
    every : int
        Of the cameras' images so many-th: two slow cores are not to be short.
    progress : callable
        Told what is done.

    Raises
    ------
    RuntimeError
        If a process failed; says which.

    """
    site = cell_site(seed, cells)
    with tempfile.TemporaryDirectory(prefix='mctrack_cells_') as name:
        folder = Path(name)
        _write_bag(site, seed, every, folder / 'detections')
        progress(f'{SECONDS:g} s of {GRID[0] * GRID[1]} cameras detected')
        prepare_nodes()
        load = _run(_processes(site, every * TICK_S, folder), folder / 'graph.log')
        with BagReader(folder / 'recorded') as reader:
            ((began, _),) = reader.rows(BEGIN, Detections)
            tracks = [
                rows.at(rows.stamp_ns - began.stamp_ns)
                for rows, _ in reader.rows('/tracks', Tracks)
            ]
    figures: dict[str, float] = {'ticks': len(tracks)}
    ids, crossings = ids_of(site.paths, tracks), crossings_of(site)
    wholes = {border: len(crossings[border]) for border in BORDERS}
    for figure, within_s in (('kept', LATE_S), ('at_once', LONG_S)):
        parts = {border: is_kept(ids, crossings[border], within_s).sum() for border in BORDERS}
        figures[figure] = sum(parts.values()) / sum(wholes.values())
    figures['crossings'] = sum(wholes.values())
    own = [value for process, value in load.items() if process.startswith('cell')]
    figures |= {'cell.core': float(np.mean(own)), 'cell.core_worst': max(own)}
    figures |= {f'{process}.core': load[process] for process in ('site', 'player', 'recorder')}
    protocol = {
        'site': f'seed {seed}: {GRID[0] * GRID[1]} cameras at {1 / (every * TICK_S):g} Hz, '
        f'{PEOPLE} people, {SECONDS:g} s, {cells} cells',
        'processes': 'a player, a fusion node for each cell and one for the site, a '
        'recorder; messages over DDS',
        'kept, at_once': 'as bench cells',
        'core': f'share of a core that a process takes over the last {_MEASURED_S:g} s, messages '
        'and all',
        'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
    }
    return Figures('bench_cells_live', 'mctrack bench cells --live', protocol, figures)


def _write_bag(site: CellSite, seed: int, every: int, path: Path) -> None:
    """Write what the cameras of all cells tell, as they tell it in lock step."""
    told: list[tuple[int, str, CameraDetections]] = []

    def hear(cell: int, message: CameraDetections) -> None:
        if (round(message.rows.stamp_ns * 1e-9 / TICK_S) - 1) % every:
            return
        stamp_ns = START_NS + message.rows.stamp_ns
        told.append((stamp_ns, f'/cell{cell}/{message.camera}/detections', message))

    play_cells(site, seed, hear)
    with BagWriter(path) as writer:
        writer.write_rows(BEGIN, Detections.build(START_NS), 'map', START_NS)
        for stamp_ns, topic, message in sorted(told, key=lambda each: each[:2]):
            writer.write_rows(topic, message.rows.at(stamp_ns), 'map', stamp_ns)


def _processes(site: CellSite, period_s: float, folder: Path) -> list[Process]:
    """Return the graph: cells in namespaces of their own."""
    names = [f'cell{cell}' for cell in range(len(site.scenes))]
    processes = []
    batching = {'period': period_s}
    for name, scene in zip(names, site.scenes):
        parameters = {
            'cameras': list(camera_names(scene.scenario)),
            'fusion': {'batching': batching},
        }
        processes.append(NodeSpec('fusion_node', name, parameters).process(folder, f'/{name}'))
    fusion = {'tracker': 'cells', 'batching': batching}
    nodes = [
        NodeSpec('fusion_node', 'site', {'cameras': names, 'fusion': fusion}),
        recorder_node(folder / 'recorded', ['/tracks', BEGIN]),
        player_node(
            folder / 'detections',
            topics=['/cell.*/detections', BEGIN],
            wait_for=[
                '/cell.*/detections',
                BEGIN,
                *(f'/{name}/tracks 1' for name in names),
                '/tracks 1',
            ],
            wait=120.0,
            restamp=True,
        ),
    ]
    return processes + [node.process(folder) for node in nodes]


def _run(processes: list[Process], log: Path) -> dict[str, float]:
    """Run a graph until its player ends; return what share of a core each process took."""
    samples: dict[str, list[tuple[float, float]]] = defaultdict(list)
    with log.open('w', encoding='utf-8') as lines:
        graph = Supervisor(
            processes, lambda line: print(line, file=lines, flush=True), ENVIRONMENT
        )
        thread = threading.Thread(target=graph.run)
        thread.start()
        while thread.is_alive():
            for name, number in graph.pids().items():
                used_s = _processor_s(number)
                if used_s is not None:
                    samples[name].append((time.monotonic(), used_s))
            time.sleep(_SAMPLE_S)
    if graph.failures:
        raise RuntimeError(f'{"; ".join(graph.failures)}\n{log.read_text("utf-8")[-2000:]}')
    ended_s = max(time_s for time_s, _ in samples['player'])
    shares = {}
    for name, each in samples.items():
        times_s, used_s = np.array([one for one in each if one[0] <= ended_s]).T
        first = int(np.searchsorted(times_s, ended_s - _MEASURED_S))
        shares[name] = float((used_s[-1] - used_s[first]) / (times_s[-1] - times_s[first]))
    return shares


def _processor_s(process: int) -> float | None:
    """Return the processor time of a process, s; None: it has ended."""
    try:
        fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / _TICKS_S
