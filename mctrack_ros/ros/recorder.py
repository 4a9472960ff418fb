"""Topics to a bag, as they come, still serialised."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.recording import BagError, BagWriter
from mctrack_ros.ros.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.messages import message_class
from mctrack_ros.ros.process import run
from mctrack_ros.ros.raw_source import Drained, RawSource
from mctrack_ros.ros.topics import EXPLANATIONS, pattern

_LOOK_S = 0.2
_DRAIN_S = 0.02
_REPORT_S = 10.0


@dataclass(frozen=True, slots=True)
class RecorderConfig:
    """Parameters of `recorder`."""

    autostart: bool = parameter(True, AUTOSTART)
    path: str = parameter('', 'directory of the bag')
    overwrite: bool = parameter(False, 'replace a bag that is there')
    topics: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; a topic whose whole name matches one is recorded'
    )
    exclude: str = parameter(
        '/(clock|rosout|parameter_events)|.*/(transition_event|debug_image)',
        'regular expression of topics that are not',
    )
    explain: bool = parameter(
        False, 'record why fusion decided as it did, too; it is worked out only if somebody asks'
    )
    depth: int = parameter(100, 'messages of a topic that may queue', minimum=1, maximum=10000)


class Recorder(GraphNode):
    """Record every topic that fits, from the moment it appears; finish the bag at the end."""

    CONFIG = RecorderConfig
    config: RecorderConfig

    def __init__(self) -> None:
        super().__init__('recorder')

    def open(self) -> None:
        """Create the bag."""
        if not self.config.path:
            raise ConfigError('path is empty: name the directory of the bag')
        self.wanted = [pattern(text) for text in self.config.topics]
        self.excluded = [pattern(self.config.exclude)]
        self.excluded += [] if self.config.explain else [EXPLANATIONS]
        self.known: set[str] = set()
        self.messages = self.bytes = 0
        self.writer = BagWriter(self.config.path, overwrite=self.config.overwrite)
        self.writing = True

    def start(self) -> None:
        """Look for topics, now and again."""
        self.simulated = bool(self.get_parameter('use_sim_time').value)
        self.known.clear()
        self.sources: list[RawSource] = []
        self.look()
        self.every(_DRAIN_S, self.drain)
        self.every(_LOOK_S, self.look)
        self.every(_REPORT_S, self.report)

    def stop(self) -> None:
        """Write what is left."""
        self.drain()

    def close(self) -> None:
        """Finish the bag; after a failure too."""
        if getattr(self, 'writing', False):
            self.writing = False
            self.writer.close()
            self.report()

    def report(self) -> None:
        """Say how far it is."""
        self.get_logger().info(
            f'{self.config.path}: {self.messages} messages of {len(self.known)} topics, '
            f'{self.bytes / 1e6:.1f} MB'
        )

    def look(self) -> None:
        """Subscribe to what has appeared and fits."""
        for topic, kinds in self.get_topic_names_and_types():
            if topic in self.known or any(each.fullmatch(topic) for each in self.excluded):
                continue
            if any(wanted.fullmatch(topic) for wanted in self.wanted):
                self.known.add(topic)
                self.record(topic, kinds[0])

    def record(self, topic: str, kind: str) -> None:
        """Record one topic from now on."""
        try:
            message = message_class(kind)
        except ValueError as error:
            self.get_logger().warning(f'{topic} is not recorded: {error}')
            return
        subscription = self.create_subscription(
            message,
            topic,
            lambda _: None,
            self.quality_of(topic),
            callback_group=Drained(),
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            raw=True,
        )
        self.sources.append(RawSource(topic, kind, subscription))

    def quality_of(self, topic: str) -> QoSProfile:
        """Return what all that publish on a topic can give."""
        offered = [info.qos_profile for info in self.get_publishers_info_by_topic(topic)]
        quality = QoSProfile(depth=self.config.depth)
        if any(offer.reliability == ReliabilityPolicy.BEST_EFFORT for offer in offered):
            quality.reliability = ReliabilityPolicy.BEST_EFFORT
        if offered and all(o.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offered):
            quality.durability = DurabilityPolicy.TRANSIENT_LOCAL
        return quality

    def drain(self) -> None:
        """Write all that has arrived, logged at the time it was received."""
        now_ns = self.get_clock().now().nanoseconds if self.simulated else None
        for source in self.sources:
            while (taken := source.take()) is not None:
                data, received_ns = taken
                self.write(source, data, received_ns if now_ns is None else now_ns)

    def write(self, source: RawSource, data: bytes, time_ns: int) -> None:
        """Write one message; what cannot be written ends the recording."""
        try:
            self.writer.write_serialized(source.topic, source.kind, data, time_ns)
        except (BagError, OSError) as error:
            self.fail(f'{source.topic}: {error}')
        self.messages += 1
        self.bytes += len(data)


def main() -> int:
    """Run the node."""
    return run(Recorder)


if __name__ == '__main__':
    sys.exit(main())
