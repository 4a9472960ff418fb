"""All faults, one after another, over one live graph."""

from __future__ import annotations

import os
import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from mctrack_experiments.bench.chaos import faults
from mctrack_experiments.bench.chaos.faults import Outcome
from mctrack_experiments.bench.chaos.graph import NODES, LiveGraph
from mctrack_experiments.bench.chaos.scene import DETECTORS, PERIOD_S
from mctrack_ros.evaluation.figures import Figures

FAULTS: dict[str, Callable[[LiveGraph, Path], Outcome]] = {
    **{
        f'killed_{node}': lambda graph, _, node=node: faults.kill(graph, node)  # type: ignore[misc]
        for node in NODES
    },
    'silent_camera': lambda graph, _: faults.silence(graph),
    'late_camera': lambda graph, _: faults.delay(graph),
    'lost_messages': lambda graph, _: faults.loss(graph),
    'clock_back': lambda graph, _: faults.clock(graph),
    'killed_recorder': lambda graph, folder: faults.killed_recorder(graph, folder / 'killed'),
    'full_disk': lambda graph, folder: faults.full_disk(graph, folder / 'full'),
    'read_only_disk': lambda graph, _: faults.read_only_disk(graph),
}
"""What goes wrong, by name; each takes the graph and a folder for a bag."""


def bench_chaos(domain: int, tell: Callable[[str], None]) -> Figures:
    """
    Let everything go wrong in a small live graph, one after another.

    Parameters
    ----------
    domain : int
        ROS domain that nobody else uses.
    tell : callable
        Takes a line about each fault.

    """
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory(prefix='mctrack_chaos_') as name:
        folder = Path(name)
        with running(folder, domain) as graph:
            for fault, tried in FAULTS.items():
                if fault == 'read_only_disk' and not faults.is_there_a_read_only_disk():
                    tell('read_only_disk: left out, no folder refuses to be written')
                    continue
                found = tried(graph, folder)
                figures[f'{fault}.named_s'] = found.named_s
                figures[f'{fault}.ids_kept'] = found.kept
                figures[f'{fault}.pause_s'] = found.pause_s
                if 'recorder' in fault or 'disk' in fault:
                    figures[f'{fault}.lost'] = found.lost
                tell(f'{fault}: {found.named_s:.2f} s, {found.kept:.0%} of ids; {found.message}')
            for node in NODES:
                for number in (signal.SIGINT, signal.SIGTERM):
                    took_s = faults.shutdown_s(graph, node, number)
                    figures[f'shutdown.{node}.{number.name}_s'] = took_s
                graph.settled()
    named = [value for key, value in figures.items() if key.endswith('.named_s')]
    kept = [value for key, value in figures.items() if key.endswith('.ids_kept')]
    ends = [value for key, value in figures.items() if key.startswith('shutdown.')]
    lost = [value for key, value in figures.items() if key.endswith('.lost')]
    figures['worst.named_s'], figures['worst.ids_kept'] = max(named), min(kept)
    figures['worst.shutdown_s'], figures['worst.lost'] = max(ends), sum(lost)
    protocol = {
        'graph': f'{", ".join(NODES)}; detections of {", ".join(DETECTORS)} besides',
        'rate_hz': f'{1 / PERIOD_S:g}',
        'named_s': 'from the fault until a warning or an error of /diagnostics names it',
        'ids_kept': 'share of four people, each in other colours, who have the same id afterwards',
        'pause_s': 'longest time between two messages on /tracks, restart of a node included',
        'lost': 'tracks that others heard and the bag lacks, but for the last 0.5 s before a kill',
        'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
    }
    return Figures('bench_chaos', 'mctrack bench chaos', protocol, figures)


@contextmanager
def running(folder: Path, domain: int) -> Iterator[LiveGraph]:
    """Yield a graph that runs and tracks all people."""
    graph = LiveGraph(folder, domain)
    try:
        graph.until(lambda: all(graph.activations(node) for node in NODES), 'all nodes are active')
        graph.settled()
        yield graph
    finally:
        graph.close()
