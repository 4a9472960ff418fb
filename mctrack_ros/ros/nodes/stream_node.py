"""Tracks and events to other media: HTTP, web sockets and MQTT, as XML and JSON."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import CodecError, rows_from_cloud
from mctrack_ros.codec.messages import stamp_ns_of
from mctrack_ros.config import parameter
from mctrack_ros.interfaces import Events, Tracks
from mctrack_ros.ros.health.stream_health import DiagnosticsConfig
from mctrack_ros.ros.node.diagnostics import Diagnostics, stream_health
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics import quality
from mctrack_ros.streams.credentials import stream_token
from mctrack_ros.streams.formats.geo import GeoReference
from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.frames import About, Assembler, Frame
from mctrack_ros.streams.mqtt import MqttConfig, MqttPublisher
from mctrack_ros.streams.serve.hub import Hub
from mctrack_ros.streams.serve.server import Place, StreamServer
from mctrack_ros.streams.sources import Archive, RunFrames

_NICENESS = 10
"""Tracking goes first where processors are short."""


@dataclass(frozen=True, slots=True)
class StreamNodeConfig:
    """Parameters of `stream_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    host: str = parameter(
        '127.0.0.1', "address that is served; other than this machine's own needs a token"
    )
    port: int = parameter(
        8090, 'port for HTTP and web sockets; 0: any free one', minimum=0, maximum=65535
    )
    token_file: str = parameter(
        '',
        'file whose first line is the token that readers bring in the header Authorization: '
        'Bearer; MCTRACK_STREAM_TOKEN in the environment goes before it',
    )
    origins: tuple[str, ...] = parameter(
        (), 'other sites whose pages may read, for example https://example.org'
    )
    readers: int = parameter(32, 'how many may read at once', minimum=1, maximum=1000)
    memory: float = parameter(
        60.0, 'how far back a reader may begin without a database [s]', minimum=0.0, maximum=3600.0
    )
    database: str = parameter(
        '',
        'trajectory database of the running graph, for readers who begin before that: a file or '
        "a URL without password, which PostgreSQL's PGPASSWORD or ~/.pgpass tells",
    )
    geo: str = parameter(
        '',
        'latitude,longitude of the origin of positions and, third, where the y axis points to, '
        'clockwise from north; for ONVIF; empty: not known [degrees]',
    )
    mqtt: MqttConfig = MqttConfig()
    diagnostics: DiagnosticsConfig = DiagnosticsConfig()


class StreamNode(GraphNode):
    """Subscribe to tracks and events and give them to whoever reads."""

    CONFIG = StreamNodeConfig
    config: StreamNodeConfig

    def __init__(self) -> None:
        super().__init__('stream_node')

    def open(self) -> None:
        """Serve."""
        config = self.config
        geo = GeoReference.read(config.geo)
        place = Place(config.host, config.port, stream_token(config.token_file), config.origins)
        self.tracks_health = stream_health(self)
        self.about = About()
        self.assembler = Assembler(self.about)
        self.archive = Archive(config.database) if config.database else None
        history = partial(RunFrames, self.archive) if self.archive else None
        self.hub = Hub(all_profiles(geo), config.memory, config.readers, history)
        self.server = StreamServer(self.hub, place, config.readers)
        self.server.start()
        self.mqtt = MqttPublisher(config.mqtt, geo) if config.mqtt.host else None
        readers = ReadersHealth(self.hub, self.mqtt)
        self.diagnostics = Diagnostics(
            self, {'tracks': self.tracks_health, 'readers': readers}, ()
        )

    def start(self) -> None:
        """Subscribe."""
        cloud = PointCloud2
        self.subscribe(String, 'site', self.on_site, quality.latched())
        self.subscribe(cloud, 'tracks', self.on_tracks, quality.reliable(10))
        self.subscribe(cloud, 'events', self.on_events, quality.reliable(100))
        self.subscribe(cloud, 'ticks', self.on_tick, quality.reliable(100))
        self.diagnostics.begin()
        names = ', '.join(f'/{name}' for name in self.hub.profiles)
        self.get_logger().info(f'http://{self.config.host}:{self.server.port} streams {names}')

    def stop(self) -> None:
        """Send what waits."""
        self.send(self.assembler.finish())

    def close(self) -> None:
        """End all streams."""
        for name in ('server', 'mqtt', 'archive'):
            part = getattr(self, name, None)
            if part is not None:
                part.close()
                setattr(self, name, None)

    def on_site(self, message: String) -> None:
        """Note which run it is."""
        try:
            self.describe(About.of_site(message.data, self.about.frame_id))
        except ValueError as error:
            self.refuse(f'site refused: {error}')

    def on_tracks(self, message: PointCloud2) -> None:
        """Begin a frame."""
        try:
            tracks = rows_from_cloud(message, Tracks)
        except CodecError as error:
            self.refuse(f'tracks refused: {error}')
            return
        self.tracks_health.arrived(tracks.stamp_ns, self.get_clock().now().nanoseconds)
        if message.header.frame_id != self.about.frame_id:
            self.describe(replace(self.about, frame_id=message.header.frame_id))
        self.send(self.assembler.add_tracks(tracks))

    def on_events(self, message: PointCloud2) -> None:
        """Add events to their frame."""
        try:
            self.assembler.add_events(rows_from_cloud(message, Events))
        except CodecError as error:
            self.refuse(f'events refused: {error}')

    def on_tick(self, message: PointCloud2) -> None:
        """Send a frame: fusion says what was admitted to a tick after all that it makes of it."""
        if stamp_ns_of(message) == self.assembler.stamp_ns:
            self.send(self.assembler.finish())

    def send(self, frame: Frame | None) -> None:
        """Give a frame to all who read."""
        if frame is not None:
            self.hub.publish(frame)
            if self.mqtt is not None:
                self.mqtt.publish(frame)

    def describe(self, about: About) -> None:
        """Say what the frames are of."""
        self.about = about
        self.assembler.about = about
        self.hub.describe(about)

    def refuse(self, reason: str) -> None:
        """Count and report a message that cannot be used."""
        self.tracks_health.count('refused')
        self.get_logger().warning(reason, throttle_duration_sec=5.0)


class ReadersHealth:
    """How many read, how many were too slow, and whether broker and database are there."""

    def __init__(self, hub: Hub, mqtt: MqttPublisher | None) -> None:
        self._hub, self._mqtt = hub, mqtt

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state."""
        values = {'readers': self._hub.count, 'dropped': self._hub.dropped}
        troubles = [self._hub.trouble] if self._hub.trouble else []
        if self._mqtt is not None:
            values['not sent to the broker'] = self._mqtt.left_out
            troubles += [] if self._mqtt.is_connected else ['the MQTT broker is away']
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if troubles else DiagnosticStatus.OK,
            name=name,
            message='; '.join(troubles) or 'serving',
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )


def main() -> int:
    """Run the node, after what tracks where processors are short."""
    with suppress(OSError):
        os.nice(_NICENESS)
    return run(StreamNode)


if __name__ == '__main__':
    sys.exit(main())
