"""A bag to topics, at its own pace."""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

from rclpy import parameter as ros_parameter
from rclpy.duration import Duration
from rclpy.lifecycle import LifecyclePublisher
from rosgraph_msgs.msg import Clock

from mctrack_ros.codec import header
from mctrack_ros.config import ConfigError, Parameter, parameter
from mctrack_ros.recording import BagError, BagReader, CutBagWarning
from mctrack_ros.ros.health.schedule_health import ScheduleHealth
from mctrack_ros.ros.interop.made_types import serialisable
from mctrack_ros.ros.node.diagnostics import DIAGNOSTICS, Diagnostics
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.playback.controls import Controls
from mctrack_ros.ros.playback.pacing import SECOND_NS, Due, Pace, Transport, shifted
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.choice import Awaited, TopicChoice
from mctrack_ros.ros.topics.definitions import definition_of
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES, starts_with_header

_ARRIVAL_S = 1.0
_NOWHERE = -1.0
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
    exclude: str = parameter('', 'regular expression of topics that are not played')
    remap: tuple[str, ...] = parameter(
        ('',), 'topics that are played under another name, as /from:=/to; empty: none'
    )
    rate: float = parameter(
        1.0, 'speed; 1: as recorded', minimum=0.001, maximum=1000.0, at_run_time=True
    )
    paused: bool = parameter(False, 'begin paused')
    burst: int = parameter(
        1, 'messages that go at once on the service burst', minimum=1, maximum=1_000_000
    )
    position: float = parameter(
        _NOWHERE,
        'set it to jump there while playing; it then returns to -1, nowhere [s]',
        minimum=-1.0,
        at_run_time=True,
    )
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
        if self.config.restamp and (self.config.rate != 1.0 or self.config.paused):
            raise ConfigError('restamp needs the rate 1.0, and cannot begin paused')
        self.bag = self.opened_bag()
        self.names = dict(_renamed(text) for text in self.config.remap if text)
        self.awaited = [Awaited.parsed(text) for text in self.config.wait_for if text]
        self.add_chosen()
        if not self.config.restamp:
            self.clock = self.publisher(Clock, '/clock', quality.reliable(10))
        self.ending = threading.Event()
        self.transport = Transport(self.config.rate, self.config.paused)
        self.controls = Controls(self, self.transport, self.config.burst, self.seek, self.skip)
        self.health = ScheduleHealth(self.doing)
        self.diagnostics = Diagnostics(self, {'playing': self.health}, ())

    def opened_bag(self) -> BagReader:
        """Return the bag; say what is cut off of it."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter('always', CutBagWarning)
            bag = BagReader(self.config.path)
        for warning in caught:
            self.get_logger().warning(str(warning.message))
        return bag

    def add_chosen(self) -> None:
        """Create the publishers of the topics that are played."""
        chosen = TopicChoice(self.config.topics, ['/clock', self.config.exclude])
        self.played: dict[str, Played] = {}
        for topic, kind in self.bag.topics.items():
            if chosen.takes(topic, [kind]):
                self.add(topic, kind)
        if not self.played:
            raise BagError(
                f'{self.config.path} has no topic that matches and whose type is installed'
            )

    def add(self, topic: str, kind: str) -> None:
        """Create the publisher of one topic, unless its type is not there as it was recorded."""
        try:
            message = serialisable(kind)
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
        topic = self.names.get(topic, topic)
        inside = topic.startswith(f'{self.get_namespace().rstrip("/")}/')
        return topic if inside or topic in _GLOBAL else topic.lstrip('/')

    def start(self) -> None:
        """Begin to play, from the beginning."""
        self.ending.clear()
        self.transport.restart()
        self.diagnostics.begin()
        if not self.config.restamp:
            self.controls.open()
        self.thread = threading.Thread(target=self.play, name='play')
        self.thread.start()

    def stop(self) -> None:
        """End in the middle."""
        self.ending.set()
        self.transport.end()
        self.thread.join()
        self.controls.close()

    def may_change(self, parameter: Parameter) -> bool:
        """Tell whether a parameter may change while it plays: not if stamps are to seem new."""
        return parameter.at_run_time and not self.config.restamp

    def changed(self, names: set[str], before: PlayerConfig) -> None:
        """Follow parameters that have changed while it plays."""
        if 'rate' in names:
            self.transport.set_rate(self.config.rate)
        if 'position' in names and self.config.position >= 0.0:
            self.seek(self.bag.begin_ns + round(self.config.position * 1e9))
            self.set_parameters([ros_parameter.Parameter('position', value=_NOWHERE)])

    def seek(self, time_ns: int) -> bool:
        """Go on at another place, by log time, ns; tell whether that is in what is played."""
        if not self.first_ns <= time_ns <= self.last_ns:
            first, asked, last = (
                f'{each // SECOND_NS}.{each % SECOND_NS:09}'
                for each in (self.first_ns, time_ns, self.last_ns)
            )
            self.get_logger().warning(
                f'no jump to {asked} s: what is played of the bag lasts from {first} to {last} s'
            )
            return False
        self.transport.jump(time_ns)
        return True

    def skip(self, seconds: float) -> None:
        """Go on so much later, or earlier, at most to where playing ends or begins, s."""
        time_ns = self.transport.next_ns + round(seconds * 1e9)
        self.seek(min(max(time_ns, self.first_ns), self.last_ns))

    def close(self) -> None:
        """Close the bag."""
        if hasattr(self, 'bag'):
            self.bag.close()

    def doing(self) -> str:
        """Return what it does now, as `/diagnostics` says it."""
        if not self.health.sent:
            return 'waiting for subscribers'
        return 'paused' if self.transport.is_paused else 'playing'

    def play(self) -> None:
        """Wait for those who listen and play; end the process unless the node is stopped."""
        try:
            self.wait_for_subscribers()
            self.warn_of_others()
            while not self.ending.is_set():
                self.play_once()
                if not self.config.loop:
                    break
            self.transport.end()
            self.wait_for_arrival()
        except Exception as error:
            self.fail(str(error))
        if not self.ending.is_set():
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
        own = Counter([*names, DIAGNOSTICS])
        shared = [name for name in names if self.count_publishers(name) > own[name]]
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

    def messages(self, from_ns: int) -> Iterator[tuple[str, bytes, int]]:
        """
        Yield topic, serialised message and log time (ns) from a time on.

        Messages of equal times come in the order of their topics' names, those of one topic as
        they were recorded.

        """
        until_ns = self.last_ns + 1 if self.config.duration else None
        stored = self.bag.serialized(list(self.played), from_ns, until_ns)
        for time_ns, same in groupby(stored, key=itemgetter(3)):
            for topic, _, data, _ in sorted(same, key=itemgetter(0)):
                yield topic, data, time_ns

    @property
    def first_ns(self) -> int:
        """Log time at which playing begins, ns."""
        return self.bag.begin_ns + round(self.config.start * 1e9)

    @property
    def last_ns(self) -> int:
        """Log time at which playing ends, ns."""
        if not self.config.duration:
            return self.bag.end_ns
        return min(self.bag.end_ns, self.first_ns + round(self.config.duration * 1e9))

    def play_once(self) -> None:
        """Play the bag from its start, and say how well time was kept."""
        from_ns: int | None = self.first_ns
        self.worst_ns = self.count = 0
        began_ns = time.monotonic_ns()
        while from_ns is not None:
            last_ns = self.play_from(from_ns)
            from_ns = self.transport.taken_jump()
        if not self.count:
            raise BagError(f'{self.config.path} holds nothing after {self.config.start} s')
        elapsed_ns = time.monotonic_ns() - began_ns
        factor = (last_ns - self.first_ns) / max(elapsed_ns, 1)
        self.get_logger().info(
            f'played {self.count} messages: real-time factor {factor:.3f}, '
            f'at most {self.worst_ns * 1e-6:.1f} ms behind'
        )

    def play_from(self, from_ns: int) -> int:
        """Play from a time on, to the end or to a jump; return the log time of the last, ns."""
        pace: Pace | None = None
        step_ns, last_ns = round(1e9 / self.config.clock_rate), from_ns
        for topic, data, time_ns in self.messages(from_ns):
            if pace is None:
                pace = self.pace_from(time_ns)
                self.transport.begin(pace)
            if self.transport.wait(time_ns, step_ns, self.send_clock) is not Due.NOW:
                return last_ns
            behind_ns = self.transport.behind_ns(time_ns)
            self.worst_ns = max(self.worst_ns, behind_ns)
            played = self.played[topic]
            if self.config.restamp and played.stamped:
                data = shifted(data, pace.shift_ns)
            self.send_clock(time_ns)
            played.publisher.publish(data)
            self.health.add(behind_ns)
            self.count, last_ns = self.count + 1, time_ns
        return last_ns

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
        return Pace(first_ns, self.transport.rate, began_ns, shift_ns)

    def send_clock(self, time_ns: int) -> None:
        """Say what time it is in the bag."""
        if not self.config.restamp:
            self.clock.publish(Clock(clock=header(RCLPY_CLASSES, time_ns, '').stamp))


def _renamed(text: str) -> tuple[str, str]:
    """Return both names of a topic that is played under another one."""
    old, separator, new = text.partition(':=')
    if not separator or not old.startswith('/') or not new:
        raise ConfigError(f'remap has {text!r}, expected /from:=/to')
    return old, new


def main() -> int:
    """Run the node."""
    return run(Player)


if __name__ == '__main__':
    sys.exit(main())
