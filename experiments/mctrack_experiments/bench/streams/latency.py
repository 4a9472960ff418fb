"""What hostile readers of the stream cost fusion: paired, with and without them, in one run."""

from __future__ import annotations

import gc
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import PointCloud2

from mctrack_experiments.bench.streams.hostile_clients import KINDS
from mctrack_ros.cli.live import prepare_nodes
from mctrack_ros.cli.sites import named_site
from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.codec.messages import stamp_ns_of
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec, stream_node
from mctrack_ros.ros.graph.site_graph import site_nodes
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

CLIENTS = sum(count for _, count in KINDS)
SEGMENT_S = 10.0
"""So long one condition lasts; the first second, in which clients come or go, does not count."""
_SETTLE_S = 1.0
_WARM_S = 10.0
_START_S = 300.0
_RESAMPLED = 2000


@dataclass
class Feeder:
    """
    Sends the detections of a bag's cameras again and again, and waits for the tracks.

    Attributes
    ----------
    milliseconds : dict of int to float
        From the last camera's message to the tracks, ms, by the tick's number.

    """

    node: Any
    ticks: Sequence[Sequence[tuple[Any, Any]]]
    period_s: float
    milliseconds: dict[int, float] = field(default_factory=dict)
    _sent: dict[int, tuple[int, float]] = field(default_factory=dict)
    _count: int = 0
    _first_ns: int = 0
    _began: float = 0.0

    def begin(self) -> None:
        """Subscribe; the first tick is now."""
        period_ns = round(self.period_s * 1e9)
        self._first_ns = time.time_ns() // period_ns * period_ns + period_ns // 2
        self._began = time.perf_counter()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self.node.create_subscription(PointCloud2, '/tracks', self._arrived, reliable(10))

    def run(self, seconds: float) -> range:
        """Send in real time; return the numbers of the ticks."""
        first = self._count
        for _ in range(round(seconds / self.period_s)):
            self._send()
            until = self._began + self._count * self.period_s
            while (left := until - time.perf_counter()) > 0:
                self._executor.spin_once(timeout_sec=left)
        return range(first, self._count)

    def _send(self) -> None:
        stamp_ns = self._first_ns + round(self._count * self.period_s * 1e9)
        for publisher, message in self.ticks[self._count % len(self.ticks)]:
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
            publisher.publish(message)
        self._sent[stamp_ns] = self._count, time.perf_counter()
        self._count += 1

    def _arrived(self, message: Any) -> None:
        sent = self._sent.pop(stamp_ns_of(message), None)
        if sent is not None:
            number, began = sent
            self.milliseconds[number] = (time.perf_counter() - began) * 1e3


def measure_latency(
    bag: Path, pairs: int, tell: Callable[[str], None] = lambda line: None
) -> dict[str, float]:
    """
    Return fusion's latency with and without hostile readers, and their ratio with its interval.

    Parameters
    ----------
    bag : Path
        With detections of the cameras of ``pitch5``.
    pairs : int
        How often both conditions are measured, one after the other, in turn first.
    tell : callable
        Told how far it is.

    """
    prepare_nodes()
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        port = free.getsockname()[1]
    site = named_site('pitch5')
    nodes = [*site_nodes(site, own_detections=True), stream_node(port)]
    seconds = _START_S + _WARM_S + 2 * pairs * SEGMENT_S
    rclpy.init()
    try:
        with _running(nodes), _clients(port, seconds) as clients:
            feeder = Feeder(rclpy.create_node('bench'), (), site.fusion.batching.period)
            feeder.ticks = _messages(bag, feeder.node, site.camera_names)
            feeder.begin()
            _wait_for_tracks(feeder)
            reader = GoodReader(port)
            gc.disable()
            try:
                feeder.run(_WARM_S)
                segments = _segments(feeder, clients, pairs, tell)
            finally:
                gc.enable()
            return _judged(feeder, segments) | reader.figures()
    finally:
        rclpy.try_shutdown()


class GoodReader(threading.Thread):
    """One who reads all the while, and counts what it reads."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self._connection = socket.create_connection(('127.0.0.1', port), 60.0)
        self._connection.sendall(b'GET /tracks.json HTTP/1.1\r\nHost: localhost\r\n\r\n')
        self._stamps: list[int] = []
        self.is_over = False
        self.start()

    def run(self) -> None:
        """Read until the connection ends."""
        text = b''
        with self._connection:
            while part := self._connection.recv(65536):
                *lines, text = (text + part).split(b'\n')
                for line in lines:
                    if line.startswith(b'{"stamp_ns":'):
                        self._stamps.append(int(line[12:].partition(b',')[0]))
        self.is_over = True

    def figures(self) -> dict[str, float]:
        """Return how many frames it read, and the longest time between two, s."""
        gaps = np.diff(np.array(self._stamps, np.int64)) / 1e9
        return {
            'reader.frames': float(len(self._stamps)),
            'reader.longest_gap_s': float(gaps.max()) if len(gaps) else float('nan'),
            'reader.was_dropped': float(self.is_over),
        }


def _messages(bag: Path, node: Any, cameras: Sequence[str]) -> list[list[tuple[Any, Any]]]:
    """Return publisher and message of each camera for each tick of a bag."""
    with BagReader(bag) as reader:
        by_camera = [
            [rows for rows, _ in reader.rows(f'/{camera}/detections', Detections)]
            for camera in cameras
        ]
    publishers = [
        node.create_publisher(PointCloud2, f'/{camera}/detections', reliable(10))
        for camera in cameras
    ]
    forwards = [
        [
            (publisher, cloud_from_rows(rows, RCLPY_CLASSES, 'map'))
            for publisher, rows in zip(publishers, tick)
        ]
        for tick in zip(*by_camera)
    ]
    forwards = forwards[len(forwards) // 4 :]  # before that, few have been seen
    return forwards + forwards[::-1]


def _wait_for_tracks(feeder: Feeder) -> None:
    end = time.monotonic() + _START_S
    while not feeder.milliseconds:
        if time.monotonic() > end:
            raise TimeoutError('fusion publishes no tracks')
        feeder.run(1.0)


def _segments(
    feeder: Feeder, clients: subprocess.Popen[str], pairs: int, tell: Callable[[str], None]
) -> list[tuple[range, range]]:
    """Return the ticks without and with clients of each pair."""
    assert clients.stdin is not None
    found = []
    for pair in range(pairs):
        ticks: dict[bool, range] = {}
        for hostile in (False, True) if pair % 2 == 0 else (True, False):
            clients.stdin.write('on\n' if hostile else 'off\n')
            clients.stdin.flush()
            feeder.run(_SETTLE_S)
            ticks[hostile] = feeder.run(SEGMENT_S - _SETTLE_S)
        found.append((ticks[False], ticks[True]))
        tell(f'pair {pair + 1} of {pairs}')
    clients.stdin.write('off\n')
    clients.stdin.flush()
    return found


def _judged(feeder: Feeder, segments: Sequence[tuple[range, range]]) -> dict[str, float]:
    """Return latencies and the ratio of their 99th percentiles, with a 95 % interval by pairs."""

    def times(ticks: range) -> NDArray[np.float64]:
        arrived = [feeder.milliseconds.get(number, float('inf')) for number in ticks]
        return np.array(arrived)

    alone, beset = ([times(pair[which]) for pair in segments] for which in (0, 1))

    def ratio(chosen: Sequence[int]) -> float:
        first, second = (
            float(np.quantile(np.concatenate([each[n] for n in chosen]), 0.99, method='higher'))
            for each in (alone, beset)
        )
        return second / first

    every = range(len(segments))
    random = np.random.default_rng(1)
    resampled = [
        ratio(random.integers(len(segments), size=len(segments)).tolist())
        for _ in range(_RESAMPLED)
    ]
    figures = {'hostile.p99_ratio': ratio(every)}
    low, high = np.quantile(resampled, (0.025, 0.975)).tolist()
    figures |= {'hostile.p99_ratio.low': low, 'hostile.p99_ratio.high': high}
    for name, each in (('alone', alone), ('hostile', beset)):
        pooled = np.concatenate(each)
        figures[f'{name}.p50_ms'] = float(np.median(pooled))
        figures[f'{name}.p99_ms'] = float(np.quantile(pooled, 0.99, method='higher'))
        figures[f'{name}.ticks'] = float(len(pooled))
        figures[f'{name}.lost'] = float(np.isinf(pooled).sum())
    return figures


@contextmanager
def _running(nodes: Sequence[NodeSpec]) -> Iterator[None]:
    """Run nodes as processes while the block runs."""
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder, tempfile.TemporaryFile() as log:
        started = [
            subprocess.Popen(
                node.process(Path(folder)).command,
                env={**os.environ, **ENVIRONMENT, 'ROS_HOME': folder},
                stdout=log,
                stderr=log,
            )
            for node in nodes
        ]
        try:
            yield
        finally:
            for process in started:
                process.terminate()
            for process in started:
                process.wait()


@contextmanager
def _clients(port: int, seconds: float) -> Iterator[subprocess.Popen[str]]:
    """Keep the clients' process while the block runs."""
    command = [sys.executable, '-m', 'mctrack_experiments.bench.streams.hostile_clients']
    process = subprocess.Popen(
        [*command, str(port), str(seconds)], stdin=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        process.terminate()
        process.wait()
