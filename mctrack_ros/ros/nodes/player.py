"""A bag to topics, at its own pace."""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass

from rclpy.duration import Duration
from rclpy.lifecycle import LifecyclePublisher
from rosgraph_msgs.msg import Clock

from mctrack_ros.codec import header
from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.recording import BagError, BagReader, CutBagWarning
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.choice import Awaited, pattern
from mctrack_ros.ros.topics.definitions import definition_of
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, message_class, starts_with_header
from mctrack_ros.ros.topics.pacing import SECOND_NS, Pace, shifted

_ARRIVAL_S = 1.0
_GLOBAL = ('/tf', '/tf_static', '/diagnostics', '/rosout', '/parameter_events')
"""Topics that ROS has in no namespace."""


@dataclass(frozen=True, slots=True)
class PlayerConfig:
    """Parameters of `player`."""

    autostart: bool = parameter(True, AUTOSTART)
    path: str = parameter('', 'folder of the bag')
    topics: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; a topic whose whole name matches one is played'
    )
    rate: float = parameter(1.0, 'speed; 1: as recorded', minimum=0.001, maximum=1000.0)
    start: float = parameter(0.0, 'where in the bag to begin [s]', minimum=0.0)
    duration: float = parameter(0.0, 'length to play; 0: all [s]', minimum=0.0)
    loop: bool = parameter(False, 'begin again at the end')
    restamp: bool = parameter(
        False, 'shift all stamps as if captured now, for nodes on system time; no /clock'
    )
    clock_rate: float = parameter(
        100.0,
        '/clock messages a second, in addition to one with each message [Hz]',
        minimum=1.0,
        maximum=1000.0,
    )
    wait_for: tuple[str, ...] = parameter(
        ('.*/image_raw(/compressed)?',),
        'regular expressions; playing starts when every played topic that matches one has a '
        'subscriber. With a number after a blank: when it has so many; if no played topic '
        'matches, topics of the graph count',
    )
    wait: float = parameter(
        20.0,
        'longest wait for these subscribers; then playing starts anyway [s]',
        minimum=0.0,
        maximum=3600.0,
    )
    settle: float = parameter(
        3.5,
        'pause between the last match and the first message; DDS takes up to 3 s to repeat '
        'what was lost during discovery [s]',
        minimum=0.0,
        maximum=60.0,
    )
    depth: int = parameter(100, 'length of the queue of each topic', minimum=1, maximum=10000)


@dataclass(frozen=True, slots=True)
class Played:
    """One topic of the bag: where it goes, and whether its messages begin with a stamp."""

    publisher: LifecyclePublisher
    stamped: bool


class Player(GraphNode):
    """Publish a bag's messages when they are due, from a thread of its own."""

    CONFIG = PlayerConfig
    config: PlayerConfig

    def __init__(self) -> None:
        super().__init__('player')

    def open(self) -> None:
        """Open the bag and create a publisher for every topic that is played."""
        if not self.config.path:
            raise ConfigError('path is empty: name the folder of the bag')
        if self.config.restamp and self.config.rate != 1.0:
            raise ConfigError(f'restamp needs the rate 1.0, got {self.config.rate}')
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter('always', CutBagWarning)
            self.bag = BagReader(self.config.path)
        for warning in caught:
            self.get_logger().warning(str(warning.message))
        wanted = [pattern(text) for text in self.config.topics]
        self.awaited = [Awaited.parsed(text) for text in self.config.wait_for if text]
        self.played: dict[str, Played] = {}
        for topic, kind in self.bag.topics.items():
            if topic != '/clock' and any(one.fullmatch(topic) for one in wanted):
                self.add(topic, kind)
        if not self.played:
            raise BagError(
                f'{self.config.path} has no topic that matches and whose type is installed'
            )
        if not self.config.restamp:
            self.clock = self.publisher(Clock, '/clock', quality.reliable(10))
        self.ending = threading.Event()

    def add(self, topic: str, kind: str) -> None:
        """Create the publisher of one topic, unless its type is not there as it was recorded."""
        try:
            message = message_class(kind)
            recorded = self.bag.definition(topic)
            definition_of(kind, [recorded.type_hash] if recorded and recorded.type_hash else [])
        except ValueError as error:
            self.get_logger().warning(f'{topic} is not played: {error}')
            return
        count = self.bag.count(topic)
        offered = quality.from_bag(self.bag.offered(topic), self.config.depth, count)
        self.played[topic] = Played(
            self.publisher(message, self.name_of(topic), offered), starts_with_header(message)
        )

    def name_of(self, topic: str) -> str:
        """Return where a topic is played: in the node's namespace, unless it is global."""
        inside = topic.startswith(f'{self.get_namespace().rstrip("/")}/')
        return topic if inside or topic in _GLOBAL else topic.lstrip('/')

    def start(self) -> None:
        """Begin to play."""
        self.ending.clear()
        self.thread = threading.Thread(target=self.play, name='play')
        self.thread.start()

    def stop(self) -> None:
        """End in the middle."""
        self.ending.set()
        self.thread.join()

    def close(self) -> None:
        """Close the bag."""
        if hasattr(self, 'bag'):
            self.bag.close()

    def play(self) -> None:
        """Wait for those who listen, play, and end the process."""
        try:
            self.wait_for_subscribers()
            self.warn_of_others()
            while not self.ending.is_set():
                self.play_once()
                if not self.config.loop:
                    break
            self.wait_for_arrival()
        except Exception as error:
            self.fail(str(error))
        self.finish()

    def wait_for_subscribers(self) -> None:
        """Wait until all listen that should, so that nothing is lost; say at once for what."""
        until = time.monotonic() + self.config.wait
        missing = self.unheard()
        if missing and self.config.wait:
            self.get_logger().info(
                f'waiting up to {self.config.wait:g} s for subscribers of {", ".join(missing)}'
            )
        while missing and time.monotonic() < until and not self.ending.wait(0.05):
            missing = self.unheard()
        if missing:
            names = ', '.join(missing)
            self.get_logger().warning(f'too few subscribe to {names}: playing anyway')
        if self.config.settle:
            self.get_logger().info(f'playing begins in {self.config.settle:g} s (settle)')
        self.ending.wait(self.config.settle)

    def unheard(self) -> list[str]:
        """Return the topics that still need subscribers."""
        return [topic for awaited in self.awaited for topic in self.missing(awaited)]

    def missing(self, awaited: Awaited) -> list[str]:
        """Return which topics have too few subscribers, or the pattern of those not there yet."""
        wanted, least = awaited.topics, awaited.subscribers
        played = [topic for topic in self.played if wanted.fullmatch(topic)]
        if played or least is None:
            return [t for t in played if self.subscribers(t) < (1 if least is None else least)]
        there = [t for t, _ in self.get_topic_names_and_types() if wanted.fullmatch(t)]
        return (
            [t for t in there if self.count_subscribers(t) < least] if there else [wanted.pattern]
        )

    def subscribers(self, topic: str) -> int:
        """Return how many subscribe to a topic that is played."""
        count: int = self.played[topic].publisher.get_subscription_count()
        return count

    def warn_of_others(self) -> None:
        """Say which topics somebody else publishes, too: those who listen get both."""
        names = [played.publisher.topic_name for played in self.played.values()]
        shared = [name for name in names if self.count_publishers(name) > 1]
        if shared:
            self.get_logger().warning(
                f'others publish {", ".join(shared)}, too, and both are received: play only what '
                'they do not, for example the images, by --topic (parameter topics)'
            )

    def wait_for_arrival(self) -> None:
        """Leave the subscribers time to ask again for what got lost."""
        until = time.monotonic() + _ARRIVAL_S
        for played in self.played.values():
            left_s = max(until - time.monotonic(), 0.0)
            played.publisher.wait_for_all_acked(Duration(seconds=left_s))

    def messages(self) -> Iterator[tuple[str, bytes, int]]:
        """Yield topic, serialised message and log time (ns) of the part that is played."""
        first_ns: int | None = None
        last_s = self.config.start + self.config.duration
        for topic, _, data, time_ns in self.bag.serialized(list(self.played)):
            first_ns = time_ns if first_ns is None else first_ns
            since_s = (time_ns - first_ns) * 1e-9
            if self.config.duration and since_s > last_s:
                return
            if since_s >= self.config.start:
                yield topic, data, time_ns

    def play_once(self) -> None:
        """Play the bag from its start, and say how well time was kept."""
        pace: Pace | None = None
        worst_ns = count = 0
        for topic, data, time_ns in self.messages():
            if pace is None:
                pace = self.pace_from(time_ns)
            if not self.wait_until(pace, time_ns):
                return
            worst_ns = max(worst_ns, time.monotonic_ns() - pace.due_ns(time_ns))
            played = self.played[topic]
            if self.config.restamp and played.stamped:
                data = shifted(data, pace.shift_ns)
            self.send_clock(time_ns)
            played.publisher.publish(data)
            count += 1
        if pace is None:
            raise BagError(f'{self.config.path} holds nothing after {self.config.start} s')
        elapsed_ns = time.monotonic_ns() - pace.began_ns
        factor = (time_ns - pace.first_ns) / max(elapsed_ns, 1)
        self.get_logger().info(
            f'played {count} messages: real-time factor {factor:.3f}, '
            f'at most {worst_ns * 1e-6:.1f} ms behind'
        )

    def pace_from(self, first_ns: int) -> Pace:
        """
        Let the first message be due now.

        Stamps are shifted by whole seconds, so that they keep their place in the fusion node's
        periods and a replay gives the same ticks; the first message waits for its second.

        """
        began_ns, shift_ns = time.monotonic_ns(), 0
        if self.config.restamp:
            now_ns = self.get_clock().now().nanoseconds
            shift_ns = -((first_ns - now_ns) // SECOND_NS) * SECOND_NS
            began_ns += first_ns + shift_ns - now_ns
        return Pace(first_ns, self.config.rate, began_ns, shift_ns)

    def wait_until(self, pace: Pace, time_ns: int) -> bool:
        """Sleep until a message is due, with `/clock` meanwhile; false: asked to end."""
        step_ns = round(1e9 / self.config.clock_rate)
        while not self.ending.is_set():
            wait_ns = pace.due_ns(time_ns) - time.monotonic_ns()
            if wait_ns <= 0:
                return True
            self.ending.wait(min(wait_ns, step_ns) * 1e-9)
            self.send_clock(min(pace.bag_ns(time.monotonic_ns()), time_ns))
        return False

    def send_clock(self, time_ns: int) -> None:
        """Say what time it is in the bag."""
        if not self.config.restamp:
            self.clock.publish(Clock(clock=header(RCLPY_CLASSES, time_ns, '').stamp))


def main() -> int:
    """Run the node."""
    return run(Player)


if __name__ == '__main__':
    sys.exit(main())
