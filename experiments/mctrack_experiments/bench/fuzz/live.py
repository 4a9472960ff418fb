"""Malformed messages into a running graph: each is counted, and the other cameras go on."""

from __future__ import annotations

import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CompressedImage, Image, PointCloud2

from mctrack_experiments.bench.fuzz.clouds import malformed_cloud, random_rows
from mctrack_experiments.bench.fuzz.images import malformed_compressed, malformed_raw
from mctrack_experiments.bench.workers import Progress, silent
from mctrack_ros.cli.live import prepare_nodes
from mctrack_ros.cli.sites import named_site
from mctrack_ros.codec import CodecError, image_from_message, rows_from_cloud
from mctrack_ros.interfaces import Detections, Events
from mctrack_ros.replay.proof.verify import verify_bag
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec, player_node, recorder_node
from mctrack_ros.ros.graph.site_graph import site_nodes
from mctrack_ros.ros.graph.supervise import Supervisor
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

BURST = 8
"""Malformed messages that go to each topic at once: no more than wait there; then all are counted.
"""

_OTHERS = '/cam[2-5]/detections'
_RECORDED = '/(cam./(detections|events)|tracks|ticks|site)'
_PATIENCE_S = 120.0


@dataclass(frozen=True, slots=True)
class Attacked:
    """
    A topic that gets malformed messages.

    Attributes
    ----------
    topic : str
        Its name.
    kind : type
        Of its messages.
    part : str
        Status on `/diagnostics` whose ``refused`` counts them.
    make : callable
        Random numbers -> a malformed message.
    read : callable
        What the node does with it.
    readers : int
        How many nodes subscribe, with the recorder.

    """

    topic: str
    kind: type[Any]
    part: str
    make: Callable[[np.random.Generator], Any]
    read: Callable[[Any], Any]
    readers: int = 1

    def refused(self, rng: np.random.Generator) -> Any:
        """Return a malformed message that the codec refuses: others are messages like any."""
        while True:
            message = self.make(rng)
            try:
                self.read(message)
            except CodecError:
                return message


@dataclass(slots=True)
class Heard:
    """The counts on `/diagnostics`, by status."""

    refused: dict[str, int] = field(default_factory=dict)
    exceptions: dict[str, int] = field(default_factory=dict)

    def take(self, message: DiagnosticArray) -> None:
        """Note what the newest message says."""
        for status in message.status:
            values = {each.key: each.value for each in status.values}
            if 'refused' in values:
                self.refused[status.name] = int(values['refused'])
            if 'exceptions' in values:
                self.exceptions[status.name] = int(values['exceptions'])


def fuzz_live(
    bag: Path, messages: int, domain: int | None = None, progress: Progress = silent
) -> dict[str, float]:
    """
    Send malformed messages of one camera into a graph that tracks what four others detect.

    The recording of the graph is replayed in lock step, where nothing malformed is: the tracks
    must be the same. The recorder takes down the malformed messages, too, and a replay passes over
    them as the fusion node does.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    messages : int
        How many are sent.
    domain : int, optional
        ROS domain; unless given, that of the environment.
    progress : callable
        Told how many were sent.

    """
    prepare_nodes()
    environment = dict(ENVIRONMENT)
    if domain is not None:
        environment['ROS_DOMAIN_ID'] = str(domain)
    lines: list[str] = []
    with tempfile.TemporaryDirectory(prefix='mctrack_fuzz_') as name:
        folder = Path(name)
        nodes, attacked = _graph(bag, folder / 'recorded')
        supervisor = Supervisor([n.process(folder) for n in nodes], lines.append, environment)
        sent, heard, errors = Counter[str](), Heard(), []

        def attack() -> None:
            try:
                with _observer(domain) as (node, executor):
                    _attack(node, executor, attacked, messages, (sent, heard), progress)
            except Exception as error:
                errors.append(error)
            finally:
                supervisor.stop()

        thread = threading.Thread(target=attack)
        thread.start()
        supervisor.run()
        thread.join()
        if errors or supervisor.failures:
            said = '\n'.join(lines[-20:])
            raise RuntimeError(f'{errors} {supervisor.failures}\n{said}')
        verdict, *_ = verify_bag(folder / 'recorded')
    return {
        'live.messages': sent.total(),
        'live.uncounted': sum(abs(sent[part] - heard.refused.get(part, 0)) for part in sent),
        'live.exceptions': sum(heard.exceptions.values()),
        'live.restarts': sum(starts - 1 for starts in supervisor.starts().values()),
        'live.ticks': verdict.ticks,
        'live.same_tracks': int(verdict.has_same_tracks and verdict.is_compared),
        'live.log_lines': len(lines),
    }


def _graph(bag: Path, recorded: Path) -> tuple[list[NodeSpec], list[Attacked]]:
    """Return the nodes, and where malformed messages go: to camera 1, which sees nothing else."""
    site = named_site('pitch5')
    fusion, camera, *_ = site_nodes(site)
    settings = {**camera.parameters['settings'], 'image_topic': 'image_raw'}
    size = settings['image_width'], settings['image_height']
    raw = replace(camera, name='cam1_raw', parameters={**camera.parameters, 'settings': settings})
    nodes = [
        replace(fusion, parameters={**fusion.parameters, 'state_file': ''}),
        *(
            replace(each, parameters={**each.parameters, 'reliable': True, 'depth': 100})
            for each in (camera, raw)
        ),
        recorder_node(recorded, [_RECORDED]),
        player_node(
            bag, topics=[_OTHERS], wait_for=[f'{_OTHERS} 2'], wait=60.0, loop=True, restamp=True
        ),
    ]

    def cloud(kind: type[Any]) -> Callable[[np.random.Generator], Any]:
        return lambda rng: malformed_cloud(RCLPY_CLASSES, rng, random_rows(kind, rng))[0]

    def rows(kind: type[Any]) -> Callable[[Any], Any]:
        return lambda message: rows_from_cloud(message, kind)

    def image(message: Any) -> Any:
        return image_from_message(message, size)

    attacked = [
        Attacked(
            f'/cam1/{kind.TOPIC or "events"}',
            PointCloud2,
            '/fusion: cam1',
            cloud(kind),
            rows(kind),
            2,
        )
        for kind in (Detections, Events)
    ]
    attacked += [
        Attacked(
            '/cam1/image_raw/compressed',
            CompressedImage,
            '/cam1_camera: cam1',
            lambda rng: malformed_compressed(RCLPY_CLASSES, rng, size)[0],
            image,
        ),
        Attacked(
            '/cam1/image_raw',
            Image,
            '/cam1_raw: cam1',
            lambda rng: malformed_raw(RCLPY_CLASSES, rng),
            image,
        ),
    ]
    return nodes, attacked


@contextmanager
def _observer(domain: int | None) -> Iterator[tuple[Node, SingleThreadedExecutor]]:
    """Give a node of this process."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('fuzz', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def _attack(
    node: Node,
    executor: SingleThreadedExecutor,
    attacked: list[Attacked],
    messages: int,
    notes: tuple[Counter[str], Heard],
    progress: Progress,
) -> None:
    """Send, then wait until all is counted."""
    sent, heard = notes
    node.create_subscription(DiagnosticArray, '/diagnostics', heard.take, reliable(10))
    tracked: list[Any] = []
    node.create_subscription(PointCloud2, '/tracks', tracked.append, reliable(10))
    publishers = [node.create_publisher(each.kind, each.topic, reliable(100)) for each in attacked]
    _until(
        executor,
        lambda: (
            tracked
            and all(
                publisher.get_subscription_count() >= each.readers
                for publisher, each in zip(publishers, attacked)
            )
        ),
        'the graph does not run',
    )
    rng = np.random.default_rng(7)
    for number in range(messages):
        index = number % len(attacked)
        publishers[index].publish(attacked[index].refused(rng))
        sent[attacked[index].part] += 1
        progress(number + 1, messages)
        if (number + 1) % (BURST * len(attacked)) == 0 or number + 1 == messages:
            _until(
                executor, lambda: all(heard.refused.get(part, 0) >= sent[part] for part in sent)
            )


def _until(
    executor: SingleThreadedExecutor, condition: Callable[[], Any], failure: str = ''
) -> None:
    """Spin until a condition holds; fail, or go on without, if it takes too long."""
    end_s = time.monotonic() + (_PATIENCE_S if failure else 10.0)
    while not condition():
        if time.monotonic() > end_s:
            if failure:
                raise RuntimeError(failure)
            return
        executor.spin_once(timeout_sec=0.1)
