"""Tracks and events of the graph to a trajectory database, as they come."""

from __future__ import annotations

import json
import math
import sys
import time
from dataclasses import dataclass
from hashlib import sha256
from operator import itemgetter
from pathlib import Path
from struct import Struct
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.ros.health.stream_health import DiagnosticsConfig
from mctrack_ros.ros.node.diagnostics import Diagnostics, Health, stream_health
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.state.track_ids import state_path
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.raw_source import subscribe_raw, take
from mctrack_ros.site.names import check_camera_name
from mctrack_ros.store import FeedOptions, Keep, LiveStore, StoreError
from mctrack_ros.store.bags import TRACKS_TOPIC
from mctrack_ros.store.database import url_of

_DRAIN_S = 0.05
_DEPTH = 200
"""Messages of a topic that may wait for the next look."""
_HELD_S = 2.0
"""Time that messages wait for the first `/site`, which says whose they are."""
_STAMP = Struct('<4xiI')
_LATE_S = 3.0
"""From then on a database is behind."""


@dataclass(frozen=True, slots=True)
class StoreNodeConfig:
    """Parameters of `store_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    database: str = parameter(
        '',
        'file of SQLite, made unless it is there, or URL: postgresql://user@host/name, without '
        'password: that is read from ~/.pgpass or PGPASSWORD',
    )
    run: str = parameter(
        '', 'name of the run, numbered from the second on; empty: run on /site is its name'
    )
    site: str = parameter('site', 'name of the site in the database')
    cameras: tuple[str, ...] = parameter(
        (), 'cameras whose events are kept from the start; those that /site names are added'
    )
    finish: bool = parameter(
        False, 'finish the run at the end; false: the next start of the node continues it'
    )
    spool: str = parameter(
        '',
        'folder for what is not in the database yet; empty: beside a file of SQLite, else below '
        'ROS_HOME or ~/.ros',
    )
    spool_bytes: int = parameter(
        1_000_000_000,
        'size of the spool; of more, the oldest messages are dropped [bytes]',
        minimum=10_000_000,
    )
    keep: str = parameter(
        '',
        'how long data is kept: 30d for all, or by kind: positions=30d,events=90d,'
        'corrections=90d,videos=30d; units s, m, h, d; empty: for ever',
    )
    diagnostics: DiagnosticsConfig = DiagnosticsConfig()


@dataclass(slots=True)
class StoreHealth:
    """
    Whether what comes is kept.

    Attributes
    ----------
    store : LiveStore
        What keeps it.
    received, dropped, refused : int
        Messages since the last report; dropped and refused ones until then.

    """

    store: LiveStore
    received: int = 0
    dropped: int = 0
    refused: int = 0

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: what is lost is an error, what waits long a warning."""
        store, spool, state = self.store, self.store.spool, self.store.state
        dropped, refused = spool.dropped - self.dropped, state.refused - self.refused
        level, message = DiagnosticStatus.OK, 'writing'
        if not self.received:
            level, message = DiagnosticStatus.STALE, 'no data'
        if refused:
            level, message = DiagnosticStatus.WARN, f'{refused} messages refused'
        if store.failure:
            level = DiagnosticStatus.WARN
            message = f'the database is away, the spool grows: {store.failure}'
        elif store.behind_s > _LATE_S:
            level = DiagnosticStatus.WARN
            message = f'the database is behind by {store.behind_s:.0f} s'
        if spool.failure:
            level, message = DiagnosticStatus.ERROR, f'the spool takes nothing: {spool.failure}'
        if dropped:
            level = DiagnosticStatus.ERROR
            message = f'{dropped} messages dropped: the spool is full'
        values = {
            'received': self.received,
            'written': state.written,
            'waiting': spool.waiting,
            'spool [bytes]': spool.size,
            'dropped': spool.dropped,
            'refused': state.refused,
            'run': state.run,
            'database': store.failure or 'there',
        }
        self.received, self.dropped, self.refused = 0, spool.dropped, state.refused
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )


class StoreNode(GraphNode):
    """Take tracks, events and `/site` as they come; a store writes them in its own threads."""

    CONFIG = StoreNodeConfig
    config: StoreNodeConfig

    def __init__(self) -> None:
        super().__init__('store_node')
        self.store: LiveStore | None = None

    def open(self) -> None:
        """Open the spool; the database may be away."""
        for camera in self.config.cameras:
            check_camera_name(camera)
        options = FeedOptions(self.config.run, self.config.site, self.config.finish)
        try:
            self.store = LiveStore(
                self.config.database,
                self.spool_folder(),
                self.config.spool_bytes,
                options,
                Keep.parsed(self.config.keep),
            )
        except StoreError as error:
            raise ConfigError(str(error)) from error
        self.health = StoreHealth(self.store)
        self.tracks_health = stream_health(self)
        parts: dict[str, Health] = {'store': self.health, 'tracks': self.tracks_health}
        self.diagnostics = Diagnostics(self, parts, ())

    def spool_folder(self) -> Path:
        """Return where messages wait."""
        if not self.config.database:
            raise ConfigError("database is '', expected a file or a URL")
        url = url_of(self.config.database)
        if self.config.spool:
            return Path(self.config.spool).expanduser().absolute()
        if url.get_backend_name() == 'sqlite':
            return Path(f'{url.database}.spool').absolute()
        node, domain = self.get_fully_qualified_name(), self.context.get_domain_id()
        state = state_path('auto', domain, node)
        assert state is not None
        return state.with_name(f'{state.stem}.{sha256(str(url).encode()).hexdigest()[:12]}.spool')

    def start(self) -> None:
        """Subscribe; cameras are known from the parameters, or from `/site`."""
        self.simulated = bool(self.get_parameter('use_sim_time').value)
        self.held: list[tuple[str, int, bytes]] = []
        self.held_s, self.waits_for_site = 0.0, True
        self.events: dict[str, Subscription[Any]] = {}
        site = quality.latched()
        site.depth = 10
        self.site = subscribe_raw(self, String, 'site', site)
        self.tracks = subscribe_raw(self, PointCloud2, 'tracks', quality.reliable(_DEPTH))
        self.add_events('/events', 'events')
        for camera in self.config.cameras:
            self.add_events(f'/{camera}/events', f'{camera}/events')
        self.every(_DRAIN_S, self.drain)
        self.diagnostics.begin()

    def stop(self) -> None:
        """Take what is left."""
        self.drain()
        self.pass_on()

    def close(self) -> None:
        """Write what waits, as far as the database takes it."""
        if self.store is None:
            return
        self.store.close()
        self.tell()
        if waiting := self.store.spool.waiting:
            text = f'{waiting} messages are in the spool: the next start writes them'
            self.get_logger().warning(text)
        self.store = None

    def add_events(self, name: str, topic: str) -> None:
        """Keep a topic of events, by its name without namespace."""
        if name not in self.events:
            self.events[name] = subscribe_raw(self, PointCloud2, topic, quality.reliable(_DEPTH))

    def drain(self) -> None:
        """Take all that has come, in the order of arrival; tracks last: events follow theirs."""
        now_ns = self.get_clock().now().nanoseconds if self.simulated else None
        sources = [(SITE_TOPIC, self.site), *self.events.items(), (TRACKS_TOPIC, self.tracks)]
        arrived = []
        for topic, subscription in sources:
            while (taken := take(subscription)) is not None:
                arrived.append((taken.received_ns, topic, taken.data))
                if topic == TRACKS_TOPIC:
                    self.note_tracks(taken.data, taken.received_ns)
        for received_ns, topic, data in sorted(arrived, key=itemgetter(0)):
            self.held.append((topic, received_ns if now_ns is None else now_ns, data))
            if topic == SITE_TOPIC:
                self.hear_site(data)
        self.health.received += len(arrived)
        if self.waits_for_site and self.held:
            self.held_s = self.held_s or time.monotonic()
            if time.monotonic() - self.held_s < _HELD_S:
                return
        self.pass_on()
        self.tell()

    def note_tracks(self, data: bytes, received_ns: int) -> None:
        """Take notice of tracks, still serialised: of their stamp, behind four bytes."""
        if len(data) < _STAMP.size:
            self.tracks_health.count('refused')
            return
        seconds, nanoseconds = _STAMP.unpack_from(data)
        self.tracks_health.arrived(seconds * 10**9 + nanoseconds, received_ns)

    def pass_on(self) -> None:
        """Hand over what has come; the first `/site` goes before what was held for it."""
        assert self.store is not None
        if self.waits_for_site and self.held:
            self.held.sort(key=lambda each: each[0] != SITE_TOPIC)
            self.waits_for_site = False
        for topic, log_ns, data in self.held:
            self.store.put(topic, log_ns, data)
        self.held.clear()

    def hear_site(self, data: bytes) -> None:
        """Keep the events of the cameras that `/site` names."""
        self.held_s = -math.inf
        try:
            cameras = json.loads(deserialize_message(data, String).data)['cameras']
            for camera in cameras:
                check_camera_name(camera)
                self.add_events(f'/{camera}/events', f'{camera}/events')
        except (ValueError, LookupError, TypeError, RuntimeError) as error:
            self.get_logger().warning(f'/site names no cameras: {error}')

    def tell(self) -> None:
        """Say what the store has to say; its threads do not log."""
        assert self.store is not None
        said = self.store.state.said
        while said:
            self.get_logger().info(said.popleft())


def main() -> int:
    """Run the node."""
    return run(StoreNode)


if __name__ == '__main__':
    sys.exit(main())
