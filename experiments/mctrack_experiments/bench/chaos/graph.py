"""A small live graph under its supervisor, and what is heard of it."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import PointCloud2

from mctrack_experiments.bench.chaos.scene import (
    CAMERA,
    DETECTORS,
    PERIOD_S,
    PLAYED,
    Feed,
    people,
    write_bag,
    write_site,
    write_video,
)
from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.interfaces import Tracks
from mctrack_ros.ros.graph.graph import (
    ENVIRONMENT,
    NodeSpec,
    coverage_node,
    player_node,
    recorder_node,
    stream_node,
)
from mctrack_ros.ros.graph.process_health import ProcessHealth
from mctrack_ros.ros.graph.site_graph import site_nodes
from mctrack_ros.ros.graph.supervise import Supervisor
from mctrack_ros.ros.topics.quality import reliable
from mctrack_ros.site.site import load_site

PATIENCE_S = 90.0
NODES = (
    'fusion',
    f'{CAMERA}_camera',
    'store',
    'coverage',
    'stream',
    'video',
    'player',
    'simulator',
)
"""The processes of the graph that are started again when they are killed."""
RECORDED = ('/tracks', '/ticks', f'/{CAMERA}/image_raw/compressed')
_GATE_M = 1.0
_FRESH_S = 1.5
_STEADY_S = 2.0
"""So long all must have been well before something goes wrong, s."""


class Said(NamedTuple):
    """What `/diagnostics` said of a part, and when it was heard on the steady clock, s."""

    name: str
    level: int
    message: str
    at_s: float
    values: Mapping[str, str]


class LiveGraph:
    """
    Nodes as processes, what feeds them, and what they say.

    Parameters
    ----------
    folder : Path
        For all files; empty.
    domain : int
        ROS domain that nobody else uses.

    Attributes
    ----------
    feed : Feed
        Its input.
    said : list of Said
        All that was said on `/diagnostics`.
    tracks : list of Tracks
        All that were heard.

    """

    def __init__(self, folder: Path, domain: int) -> None:
        self.folder, self.domain = folder, domain
        self.said: list[Said] = []
        self.tracks: list[Tracks] = []
        self.lines: list[str] = []
        self._times_s: list[float] = []
        self._context = rclpy.Context()
        rclpy.init(
            args=[],
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self._node = rclpy.create_node('observer', context=self._context)
        self._node.create_subscription(PointCloud2, '/tracks', self._on_tracks, reliable(100))
        self._node.create_subscription(
            DiagnosticArray, '/diagnostics', self._on_diagnostics, reliable(100)
        )
        self.feed = Feed(self._node)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._ending = threading.Event()
        self._spinning = threading.Thread(target=self._spin, name='observer')
        self._spinning.start()
        self._environment = {
            **ENVIRONMENT,
            'ROS_DOMAIN_ID': str(domain),
            'ROS_HOME': str(folder / 'ros_home'),
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        }
        self.supervisor, self._running = self._supervised(self._specs(), '')

    def close(self) -> None:
        """End all."""
        self.supervisor.stop()
        self._running.join()
        self._ending.set()
        self._spinning.join()
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def until(
        self, condition: Callable[[], Any], what: str, patience_s: float = PATIENCE_S
    ) -> Any:
        """
        Wait until something is true, and return it.

        Raises
        ------
        RuntimeError
            If it does not become so; says what was waited for, and what the nodes said last.

        """
        end_s = time.monotonic() + patience_s
        while time.monotonic() < end_s:
            if found := condition():
                return found
            time.sleep(0.02)
        last = '\n'.join(self.lines[-20:])
        raise RuntimeError(
            f'waited {patience_s:g} s in vain until {what}; the nodes said:\n{last}'
        )

    def ids(self) -> dict[int, int] | None:
        """Return the id of each person's track in the last message; None: not all have one."""
        if not self.tracks:
            return None
        tracks = self.tracks[-1]
        stamp_s = tracks.stamp_ns * 1e-9
        if time.time() - stamp_s > _FRESH_S or not len(tracks):
            return None
        gaps = np.linalg.norm(tracks.position[:, None, :2] - people(stamp_s), axis=2)
        nearest = gaps.argmin(axis=0)
        if (gaps.min(axis=0) > _GATE_M).any():
            return None
        return {person: int(tracks.track_id[row]) for person, row in enumerate(nearest)}

    def settled(self) -> dict[int, int]:
        """Wait until all people have a track and all processes run; return their ids."""

        def found() -> dict[int, int] | None:
            is_up = all(state.is_running for state in self.supervisor.states())
            return self.ids() if is_up else None

        ids: dict[int, int] = self.until(found, 'all are tracked')
        return ids

    def settled_after(self, part: str, words: str) -> dict[int, int]:
        """Wait until a part has no such fault, and ids are the same, for a while."""

        def is_well() -> bool:
            return self.named(time.monotonic() - _STEADY_S, part, words) is None

        self.until(is_well, f'{part} is well')
        ids, since_s = self.settled(), time.monotonic()
        while time.monotonic() < since_s + _STEADY_S:
            time.sleep(PERIOD_S)
            if (now := self.settled()) != ids:
                ids, since_s = now, time.monotonic()
        return ids

    def activations(self, name: str) -> int:
        """Return how often a node of the graph has become active."""
        return sum(
            line.startswith(f'[{name}]') and line.endswith(': active') for line in self.lines
        )

    def named(self, since_s: float, part: str, words: str) -> Said | None:
        """Return the first warning or error about a part, with some words, from a time on."""
        return next(
            (
                one
                for one in self.said[:]
                if one.at_s >= since_s
                and one.level
                and one.name.endswith(part)
                and words in one.message
            ),
            None,
        )

    def kill(self, name: str) -> None:
        """Kill a process with -9."""
        os.kill(self.supervisor.pids()[name], signal.SIGKILL)

    @contextmanager
    def recorder(self, path: Path, **parameters: Any) -> Iterator[Supervisor]:
        """Run a recorder under a supervisor of its own, which reports, too."""
        values: dict[str, Any] = {'min_free_mb': 0.0} | parameters
        spec = recorder_node(path, RECORDED, **values)
        supervisor, running = self._supervised([spec], '/recording')
        try:
            yield supervisor
        finally:
            supervisor.stop()
            running.join()

    def process(self, spec: NodeSpec) -> tuple[tuple[str, ...], Mapping[str, str]]:
        """Return the command of a node, and its environment."""
        command = spec.process(self.folder).command
        return command, {**os.environ, **self._environment, 'PYTHONUNBUFFERED': '1'}

    def _specs(self) -> list[NodeSpec]:
        """Return the nodes: fusion of all cameras, the node of one, and all others there are."""
        path = write_site(self.folder)
        fusion, camera = site_nodes(load_site(path))
        cameras = [CAMERA, PLAYED, *DETECTORS]
        values = dict(fusion.parameters) | {'cameras': cameras, 'site': ''}
        store = {'database': str(self.folder / 'tracks.db')}
        video = {'camera': CAMERA, 'source': str(write_video(self.folder)), 'loop': True}
        player = player_node(write_bag(self.folder), loop=True, restamp=True, settle=0.0)
        simulator = {'scene': 'carpark', 'cameras': ['cam1'], 'rate': 1.0, 'duration': 10.0}
        return [
            NodeSpec('fusion_node', 'fusion', values),
            camera,
            NodeSpec('store_node', 'store', store),
            coverage_node(path),
            stream_node(0),
            NodeSpec('video_node', 'video', video),
            replace(player, restart=True, ends=False),
            NodeSpec('simulator_node', 'simulator', simulator),
        ]

    def _supervised(
        self, specs: list[NodeSpec], namespace: str
    ) -> tuple[Supervisor, threading.Thread]:
        """Run nodes as `mctrack run` does."""
        health = ProcessHealth(namespace, self.domain)
        processes = [spec.process(self.folder) for spec in specs]
        supervisor = Supervisor(processes, self._write, self._environment, health.look)

        def run() -> None:
            supervisor.run()
            health.close()

        thread = threading.Thread(target=run, name='supervisor')
        thread.start()
        return supervisor, thread

    def said_s(self, words: str) -> float:
        """Return when a process first said some words, on the steady clock, s."""
        return next(at_s for at_s, line in zip(self._times_s, self.lines) if words in line)

    def _write(self, line: str) -> None:
        self._times_s.append(time.monotonic())
        self.lines.append(line)

    def _spin(self) -> None:
        while not self._ending.is_set():
            self._executor.spin_once(timeout_sec=PERIOD_S)

    def _on_tracks(self, message: PointCloud2) -> None:
        self.tracks.append(rows_from_cloud(message, Tracks))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        now_s = time.monotonic()
        for status in message.status:
            level = int.from_bytes(status.level, sys.byteorder)
            values = {each.key: each.value for each in status.values}
            self.said.append(Said(status.name, level, status.message, now_s, values))
