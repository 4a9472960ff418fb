"""Whether memory and latency of a live site stay as they are, hour after hour."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections import defaultdict
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from scipy.stats import theilslopes
from sensor_msgs.msg import PointCloud2

from mctrack_experiments.bench.workers import Progress, silent
from mctrack_ros.cli.live import prepare_nodes
from mctrack_ros.cli.sites import named_site
from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import Tracks
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec, player_node, recorder_node
from mctrack_ros.ros.graph.site_graph import awaited_topics, site_nodes, store_node
from mctrack_ros.ros.graph.supervise import Supervisor
from mctrack_ros.ros.topics.quality import reliable
from mctrack_ros.simulation import GreyCarParkScenario
from mctrack_ros.simulation.recording import simulate

CAMERAS, RATE_HZ, ROUND_S = 2, 5.0, 30.0
"""Cameras of the site, images a second, how long people come and go until all begins again."""

FIRST_S, FIRST_SHARE = 600.0, 1 / 3
"""What the rest is compared with: the first ten minutes, of a short run the first third."""

WARM_S = 20.0
"""After the first tracks; nothing is measured before."""

SPLIT_S = 300.0
"""Length of the recorder's files: an MCAP file's index grows in memory until the file ends."""

_SAMPLE_S = 5.0
_RECORDED = '/(cam.*/(detections|events)|tracks|events|feedback|ticks|site|diagnostics)'


@dataclass(slots=True)
class Watched:
    """
    What was seen of a graph since it was warm.

    Attributes
    ----------
    memory : dict of str to list of (float, float)
        Of each process: time, s, and resident memory, MB.
    latencies : list of (float, float)
        Of each message on `/tracks`: time, s, and from capture to arrival, ms.
    ids : set of int
        Of the tracks.

    """

    memory: dict[str, list[tuple[float, float]]] = field(default_factory=lambda: defaultdict(list))
    latencies: list[tuple[float, float]] = field(default_factory=list)
    ids: set[int] = field(default_factory=set)

    def figures(self, seconds: float, first_s: float) -> dict[str, float]:
        """Compare what came after the first minutes with these."""
        figures: dict[str, float] = {}
        for name, samples in self.memory.items():
            time_s, used_mb = np.array(samples).T
            later = time_s >= first_s
            slope, *_ = theilslopes(used_mb[later], time_s[later] - seconds)
            figures[f'memory.{name}.growth'] = (
                slope * (seconds - first_s) / np.median(used_mb[later])
            )
            figures[f'memory.{name}.end_mb'] = float(used_mb[-1])
        time_s, late_ms = np.array(self.latencies).T
        before, after = late_ms[time_s < first_s], late_ms[time_s >= first_s]
        for part, values in (('first', before), ('rest', after)):
            for share in (50, 99):
                figures[f'latency.{part}.p{share}_ms'] = float(np.percentile(values, share))
        growths = [value for name, value in figures.items() if name.endswith('.growth')]
        return {
            'memory.growth': max(growths),
            'latency.p99_ratio': figures['latency.rest.p99_ms'] / figures['latency.first.p99_ms'],
            **figures,
            'ticks': len(late_ms),
            'ids': len(self.ids),
        }


def bench_soak(minutes: float, domain: int | None = None, progress: Progress = silent) -> Figures:
    """
    Run a small site live: two cameras with images, fusion, store, recorder.

    Parameters
    ----------
    minutes : float
        How long.
    domain : int, optional
        ROS domain; unless given, that of the environment.
    progress : callable
        Told how many seconds of how many have passed.

    Raises
    ------
    RuntimeError
        If a process failed, or had to be started again; says which.

    """
    seconds = 60.0 * minutes
    first_s = min(FIRST_S, FIRST_SHARE * seconds)
    with tempfile.TemporaryDirectory(prefix='mctrack_soak_') as name, ExitStack() as stack:
        folder = Path(name)
        scenario = GreyCarParkScenario(duration_s=ROUND_S, rate_hz=RATE_HZ, cameras=CAMERAS)
        simulate(scenario, folder / 'images')
        prepare_nodes()
        environment = dict(ENVIRONMENT)
        if domain is not None:
            environment['ROS_DOMAIN_ID'] = str(domain)
        log = stack.enter_context((folder / 'graph.log').open('w', encoding='utf-8'))
        supervisor = Supervisor(
            [node.process(folder) for node in _nodes(folder)],
            lambda line: print(line, file=log, flush=True),
            environment,
        )
        watched = Watched()
        loads = []

        def watch() -> None:
            try:
                _watch(supervisor, watched, seconds, domain, progress)
                loads.append(os.getloadavg()[2])
            finally:
                supervisor.stop()

        thread = threading.Thread(target=watch)
        thread.start()
        supervisor.run()
        thread.join()
        again = [name for name, starts in supervisor.starts().items() if starts > 1]
        if supervisor.failures or again or not loads:
            said = (folder / 'graph.log').read_text(encoding='utf-8')[-2000:]
            failures = '; '.join(supervisor.failures) or f'started again: {again}'
            raise RuntimeError(f'{failures}\n{said}')
        lines = (folder / 'graph.log').read_text(encoding='utf-8').count('\n')
    figures = watched.figures(seconds, first_s) | {'log_lines': lines}
    protocol = {
        'site': f'grey car park, {CAMERAS} cameras, {RATE_HZ:g} images of 640 x 480 px a second, '
        f'the same {ROUND_S:g} s of people and cars again and again',
        'processes': f'player, {CAMERAS} camera nodes, fusion, store (SQLite), recorder '
        f'(a file each {SPLIT_S / 60:g} minutes)',
        'minutes': minutes,
        'first': f'{first_s / 60:g} minutes, from {WARM_S:g} s after the first tracks on',
        'growth': 'of resident memory over the rest, by its median slope (Theil-Sen), of its '
        'median; of the process that grows most',
        'latency': 'from the capture of the images to the arrival of /tracks elsewhere',
        'load': f'{loads[0]:.1f} processes wanted the CPUs in the last 15 minutes; '
        f'nice {os.getpriority(os.PRIO_PROCESS, 0)}',
    }
    return Figures('bench_soak', 'mctrack bench soak', protocol, figures)


def _nodes(folder: Path) -> list[NodeSpec]:
    """Return the graph; what it keeps goes into a folder."""
    site = named_site('grey_carpark')
    batching = replace(site.fusion.batching, period=1 / RATE_HZ)
    site = replace(
        site,
        cameras=dict(list(site.cameras.items())[:CAMERAS]),
        fusion=replace(site.fusion, batching=batching),
    )
    fusion, *cameras = site_nodes(site)
    fusion = replace(fusion, parameters={**fusion.parameters, 'state_file': str(folder / 'ids')})
    return [
        fusion,
        *cameras,
        store_node(folder / 'tracks.db', site),
        recorder_node(folder / 'recorded', [_RECORDED], split_s=SPLIT_S),
        player_node(
            folder / 'images',
            topics=['/cam.*/image_raw/compressed'],
            wait_for=awaited_topics(site, recorded=True, stored=True),
            wait=120.0,
            loop=True,
            restamp=True,
        ),
    ]


def _watch(
    supervisor: Supervisor,
    watched: Watched,
    seconds: float,
    domain: int | None,
    progress: Progress,
) -> None:
    """Hear tracks and look at the processes' memory until the time is over."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('soak', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    warm_s: float | None = None

    def hear(message: PointCloud2) -> None:
        nonlocal warm_s
        rows = rows_from_cloud(message, Tracks)
        now_s = time.monotonic()
        if warm_s is None:
            warm_s = now_s + WARM_S
        if now_s >= warm_s:
            watched.latencies.append((now_s - warm_s, (time.time_ns() - rows.stamp_ns) * 1e-6))
            watched.ids.update(rows.track_id.tolist())

    node.create_subscription(PointCloud2, '/tracks', hear, reliable(100))
    given_up_s, next_s = time.monotonic() + 300.0, 0.0
    try:
        while not supervisor.failures:
            executor.spin_once(timeout_sec=0.2)
            now_s = time.monotonic()
            if warm_s is None:
                if now_s > given_up_s:
                    raise RuntimeError('no tracks came')
                continue
            if now_s >= max(next_s, warm_s):
                next_s = now_s + _SAMPLE_S
                progress(min(int(now_s - warm_s), int(seconds)), int(seconds))
                for name, number in supervisor.pids().items():
                    watched.memory[name].append((now_s - warm_s, _resident_mb(number)))
            if now_s >= warm_s + seconds:
                return
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def _resident_mb(process: int) -> float:
    """Return the memory of a process that is in use, MB."""
    pages = int(Path(f'/proc/{process}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6
