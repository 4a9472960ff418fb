"""Topics to a bag, as they come, still serialised."""

from __future__ import annotations

import json
import math
import shutil
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.recording import PARAMETERS, BagError, BagWriter, Storage
from mctrack_ros.recording.track_log.log import RECORDING
from mctrack_ros.ros.health.recording_health import Recorded, RecordingHealth
from mctrack_ros.ros.interop.made_types import serialisable
from mctrack_ros.ros.node.diagnostics import DIAGNOSTICS, Diagnostics
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.other_parameters import NodeParameters
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics.choice import (
    EXPLANATIONS,
    SITE_TYPE,
    TopicChoice,
    are_images,
    is_private,
)
from mctrack_ros.ros.topics.definitions import definition_of
from mctrack_ros.ros.topics.quality import latched, to_bag
from mctrack_ros.ros.topics.raw_source import RawSource, subscribe_raw

_LOOK_S = 0.2
_DRAIN_S = 0.02
_FLUSH_S = 0.5
"""Most that is lost when the process is killed, s."""
_REPORT_S = 10.0
_MB = 1_000_000
_ASK_S = 2.0
"""How long pictures wait for a site to say whether it is private."""


@dataclass(frozen=True, slots=True)
class RecorderConfig:
    """Parameters of `recorder`."""

    autostart: bool = parameter(True, AUTOSTART)
    path: str = parameter('', 'folder of the bag')
    overwrite: bool = parameter(False, 'replace an existing bag')
    topics: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; a topic whose whole name matches one is recorded'
    )
    exclude: str = parameter(
        '/(clock|rosout|parameter_events)|.*/(transition_event|debug_image)',
        'regular expression of topics that are not recorded',
    )
    types: tuple[str, ...] = parameter(
        ('.*',), 'regular expressions; of these message types alone a topic is recorded'
    )
    storage: str = parameter(
        'mcap', 'mcap (in compressed chunks) or sqlite3', choices=('mcap', 'sqlite3')
    )
    split_mb: float = parameter(
        0.0, 'size from which another file is begun; 0: none is [MB]', minimum=0.0
    )
    split_s: float = parameter(
        0.0, 'time after which another file is begun; 0: none is [s]', minimum=0.0
    )
    min_free_mb: float = parameter(
        500.0,
        'free disk space with which recording stops; 0: it goes on [MB]',
        minimum=0.0,
        at_run_time=True,
    )
    site: str = parameter('', 'site YAML that the bag carries with its calibrations; empty: none')
    explain: bool = parameter(
        False, 'also record the explanations of fusion, which it publishes only on demand'
    )
    private: bool = parameter(
        False,
        'record no pictures, from the first message on; they are also left out as soon as a '
        'private site is heard',
    )
    depth: int = parameter(100, 'length of the queue of each topic', minimum=1, maximum=10000)


class Recorder(GraphNode):
    """Record every topic that fits, from the moment it appears; finish the bag at the end."""

    CONFIG = RecorderConfig
    config: RecorderConfig

    def __init__(self) -> None:
        super().__init__('recorder')
        self.parameters = NodeParameters(self)

    def open(self) -> None:
        """Create the bag."""
        if not self.config.path:
            raise ConfigError('path is empty: name the folder of the bag')
        unwanted = [self.config.exclude, *([] if self.config.explain else [EXPLANATIONS])]
        self.topics = TopicChoice(self.config.topics, unwanted, self.config.types)
        self.sources: dict[str, RawSource] = {}
        self.heard_before: defaultdict[str, Counter[str]] = defaultdict(Counter)
        self.left_out: dict[str, str] = {}
        self.asked_s: dict[str, float] = {}
        self.messages = self.bytes = 0
        self.create_bag()
        self.parameters.begin()
        self.diagnostics = Diagnostics(self, {'recording': RecordingHealth(self.recorded)}, ())

    def create_bag(self) -> None:
        """Create the bag, with the site that it carries; a private one allows no pictures."""
        self.private = self.config.private
        storage = Storage(
            self.config.storage,
            self.config.storage == 'mcap',
            round(self.config.split_mb * _MB),
            round(self.config.split_s * 1e9),
        )
        path = Path(self.config.path)
        self.writer = BagWriter(path, overwrite=self.config.overwrite, storage=storage)
        self.writing = True
        if self.config.site:
            from mctrack_ros.site.portable import portable_site  # loads cameras' code
            from mctrack_ros.site.site import load_site

            self.writer.attach(portable_site(self.config.site), 'application/octet-stream')
            self.private |= load_site(self.config.site).private
        if self.lacks_room():
            raise BagError(f'{path} has less than {self.config.min_free_mb:g} MB left')

    def start(self) -> None:
        """Look for topics, now and again."""
        self.simulated = bool(self.get_parameter('use_sim_time').value)
        for source in list(self.sources.values()):
            self.end(source)
        self.asked_s.clear()
        self.look()
        self.diagnostics.begin()
        self.every(_DRAIN_S, self.drain)
        self.every(_LOOK_S, self.look)
        self.every(_FLUSH_S, self.flush)
        self.every(_REPORT_S, self.report)

    def stop(self) -> None:
        """Write what is left."""
        self.drain()

    def close(self) -> None:
        """Finish the bag; after a failure too. Lost messages are a failure."""
        if not getattr(self, 'writing', False):
            return
        self.writing = False
        counts = self.counts()
        content = json.dumps(counts, indent=1).encode()
        self.writer.attach({RECORDING: content}, 'application/json')
        self.writer.close()
        self.report()
        lost = [f'{topic} {count["lost"]}' for topic, count in counts.items() if count['lost']]
        if lost:
            self.failure = f'messages were lost: {", ".join(lost)}'
            self.get_logger().error(self.failure)

    def counts(self) -> dict[str, dict[str, int]]:
        """Return by topic how many messages came, and how many did not."""
        counts = {topic: Counter(count) for topic, count in self.heard_before.items()}
        for topic, source in self.sources.items():
            counts.setdefault(topic, Counter()).update(source.counts())
        return {
            topic: {name: count[name] for name in ('received', 'lost')}
            for topic, count in sorted(counts.items())
        }

    def end(self, source: RawSource) -> None:
        """Hear a source no more; what came of it counts."""
        del self.sources[source.topic]
        self.heard_before[source.topic].update(source.counts())

    def flush(self) -> None:
        """Put what came on the disk, while there is room."""
        try:
            self.writer.flush()
        except OSError as error:
            self.fail(f'{self.config.path}: {error}')
            return
        if self.lacks_room():
            self.fail(f'less than {self.config.min_free_mb:g} MB are left on the disk: it stops')
        content = self.parameters.news()
        if content:
            self.writer.attach({PARAMETERS: content}, 'application/yaml')

    def room(self) -> int:
        """Return how many bytes may still be written."""
        free = shutil.disk_usage(self.config.path).free
        return free - round(self.config.min_free_mb * _MB)

    def lacks_room(self) -> bool:
        """Tell whether the disk is nearly full."""
        return self.room() < 0

    def recorded(self) -> Recorded:
        """Return how far it is."""
        return Recorded(
            len(self.sources),
            self.messages,
            self.bytes,
            self.lost(),
            len(self.left_out),
            self.room(),
        )

    def lost(self) -> int:
        """Return how many messages did not come."""
        return sum(count['lost'] for count in self.counts().values())

    def report(self) -> None:
        """Say how far it is, and what it leaves out."""
        text = (
            f'{self.config.path}: {self.messages} messages of {len(self.sources)} topics, '
            f'{self.bytes / 1e6:.1f} MB'
        )
        lost = self.lost()
        text += f', {lost} lost' if lost else ''
        if self.left_out:
            text += f'; {len(self.left_out)} left out: {", ".join(sorted(self.left_out))}'
        self.get_logger().info(text)

    def look(self) -> None:
        """Subscribe to what has appeared and fits; follow what its publishers offer."""
        self.parameters.look()
        topics = self.get_topic_names_and_types()
        self.ask_sites(topics)
        for topic, kinds in topics:
            if topic in self.left_out or not self.topics.takes(topic, kinds):
                continue
            if are_images(kinds) and self.withholds(topic):
                continue
            source, count = self.sources.get(topic), self.count_publishers(topic)
            if count == 1 and topic == DIAGNOSTICS:
                continue  # nobody but this node
            if count and count != (len(source.offered) if source else 0):
                self.hear(topic, kinds, source)

    def ask_sites(self, topics: Sequence[tuple[str, Sequence[str]]]) -> None:
        """Listen to every site that is described: one may be private."""
        for topic, kinds in topics:
            is_site = topic.endswith('/site') and list(kinds) == [SITE_TYPE]
            if is_site and topic not in self.asked_s and self.count_publishers(topic):
                self.asked_s[topic] = time.monotonic()
                self.subscribe(String, topic, partial(self.on_site, topic), latched())

    def on_site(self, topic: str, message: String) -> None:
        """Record no picture from now on if a site is private."""
        self.asked_s[topic] = -math.inf
        if not self.private and is_private(message.data):
            self.private = True
            for source in list(self.sources.values()):
                if are_images([source.kind]):
                    self.withholds(source.topic)

    def withholds(self, topic: str) -> bool:
        """Tell whether pictures of a topic are not recorded, or not yet: a site has to answer."""
        if self.private:
            self.leave_out(topic, 'pictures are not recorded in private mode')
            return True
        return any(time.monotonic() - asked_s < _ASK_S for asked_s in self.asked_s.values())

    def hear(self, topic: str, kinds: Sequence[str], source: RawSource | None) -> None:
        """Record a topic from now on, or hear those who publish it now, too."""
        publishers = self.get_publishers_info_by_topic(topic)
        hashes = {str(each.topic_type_hash) for each in publishers} - {'INVALID'}
        offered = [to_bag(each.qos_profile) for each in publishers]
        try:
            if len(kinds) > 1:
                raise ValueError(f'it has several message types: {", ".join(kinds)}')
            message = serialisable(kinds[0])
            definition = definition_of(kinds[0], hashes)
        except ValueError as error:
            self.leave_out(topic, str(error))
            return
        quality = self.quality_for([each.qos_profile for each in publishers])
        if source is None:
            subscription = subscribe_raw(self, message, topic, quality)
            self.sources[topic] = RawSource(topic, kinds[0], definition, offered, subscription)
            return
        source.offered = offered
        if quality.reliability != source.subscription.qos_profile.reliability:
            self.drain()
            self.destroy_subscription(source.subscription)
            source.subscription = subscribe_raw(self, message, topic, quality)

    def leave_out(self, topic: str, reason: str) -> None:
        """Record no more of a topic, and say so once."""
        source = self.sources.get(topic)
        if source is not None:
            self.end(source)
            self.destroy_subscription(source.subscription)
        self.left_out[topic] = reason
        self.get_logger().warning(f'{topic} is not recorded: {reason}')

    def quality_for(self, offered: Sequence[QoSProfile]) -> QoSProfile:
        """Return what all that publish on a topic can give."""
        quality = QoSProfile(depth=self.config.depth)
        if any(offer.reliability == ReliabilityPolicy.BEST_EFFORT for offer in offered):
            quality.reliability = ReliabilityPolicy.BEST_EFFORT
        if all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offered):
            quality.durability = DurabilityPolicy.TRANSIENT_LOCAL
        return quality

    def drain(self) -> None:
        """Write all that has arrived, logged at the time it was received."""
        now_ns = self.get_clock().now().nanoseconds if self.simulated else None
        for source in list(self.sources.values()):
            while source.topic in self.sources and (taken := source.take()) is not None:
                data, received_ns = taken
                self.write(source, data, received_ns if now_ns is None else now_ns)

    def write(self, source: RawSource, data: bytes, time_ns: int) -> None:
        """Write one message; a full disk ends the recording."""
        try:
            self.writer.write_serialized(
                source.topic, source.kind, data, time_ns, source.definition, source.offered
            )
        except BagError as error:
            self.leave_out(source.topic, str(error))
        except OSError as error:
            self.fail(f'{source.topic}: {error}')
        else:
            self.messages += 1
            self.bytes += len(data)


def main() -> int:
    """Run the node."""
    return run(Recorder)


if __name__ == '__main__':
    sys.exit(main())
