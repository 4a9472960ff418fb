"""The stream to an MQTT broker, in ONVIF's topics."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from paho.mqtt.client import Client, MQTTMessageInfo
from paho.mqtt.enums import CallbackAPIVersion

from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.streams.credentials import user_and_password
from mctrack_ros.streams.formats import onvif
from mctrack_ros.streams.formats.geo import GeoReference
from mctrack_ros.streams.frames import Frame

_MOST_UNSENT = 25
"""Messages that may wait for the broker; while they do, frames are left out."""
_RETRY_S = (1, 30)


@dataclass(frozen=True, slots=True)
class MqttConfig:
    """Where the stream is published."""

    host: str = parameter('', 'MQTT broker; empty: none')
    port: int = parameter(1883, 'its port; 8883 is usual with tls', minimum=1, maximum=65535)
    prefix: str = parameter('mctrack', 'what the topics begin with')
    rate: float = parameter(
        5.0,
        'frames a second at most, but for those that say who became who; events are all sent [Hz]',
        minimum=0.01,
        maximum=1000.0,
    )
    tls: bool = parameter(False, 'encrypt the connection, and check the certificate')
    ca_file: str = parameter('', "certificates to check it against; empty: the system's")
    credentials_file: str = parameter(
        '',
        'file with user name and password, a line each; MCTRACK_MQTT_USERNAME and '
        'MCTRACK_MQTT_PASSWORD in the environment go before it',
    )


class MqttPublisher:
    """
    Publish frames and events as JSON while a broker is there; what it misses is left out.

    Parameters
    ----------
    config : MqttConfig
        The broker.
    geo : GeoReference, optional
        Where the site lies.

    Attributes
    ----------
    left_out : int
        Frames and events that were not sent: the broker was away or slow.

    Raises
    ------
    ConfigError
        If the prefix cannot be one, or a file cannot be read.

    """

    def __init__(self, config: MqttConfig, geo: GeoReference | None = None) -> None:
        if not config.prefix or set(config.prefix) & set('#+'):
            raise ConfigError(f'mqtt.prefix is {config.prefix!r}, expected a name without # and +')
        self._prefix, self._geo = config.prefix.strip('/'), geo
        self._period_ns = round(1e9 / config.rate)
        self._next_ns = 0
        self._unsent: deque[MQTTMessageInfo] = deque()
        self.left_out = 0
        self._client = _client(config)
        self._client.connect_async(config.host, config.port)
        self._client.loop_start()

    def publish(self, frame: Frame) -> None:
        """Send a frame's events, and itself unless one was just sent and nobody changed his id."""
        for notification in onvif.notifications(frame):
            topic = onvif.event_topic(self._prefix, notification)
            self._send(topic, onvif.json_event(notification), 1)
        is_back = frame.stamp_ns < frame.before.stamp_ns
        if is_back or frame.stamp_ns >= self._next_ns or onvif.object_tree(frame):
            self._next_ns = frame.stamp_ns + self._period_ns
            self._send(onvif.metadata_topic(self._prefix), onvif.json_frame(frame, self._geo), 0)

    def close(self) -> None:
        """Leave the broker."""
        self._client.disconnect()
        self._client.loop_stop()

    @property
    def is_connected(self) -> bool:
        """Whether the broker is there."""
        return self._client.is_connected()

    def _send(self, topic: str, payload: str, quality: int) -> None:
        while self._unsent and self._unsent[0].is_published():
            self._unsent.popleft()
        if not self.is_connected or len(self._unsent) >= _MOST_UNSENT:
            self.left_out += 1
            return
        self._unsent.append(self._client.publish(topic, payload, quality))


def _client(config: MqttConfig) -> Client:
    """Return a client that knows how to log in, and waits longer and longer before it retries."""
    client = Client(CallbackAPIVersion.VERSION2)
    client.reconnect_delay_set(*_RETRY_S)
    user, password = user_and_password('MQTT', config.credentials_file)
    if user:
        client.username_pw_set(user, password or None)
    if config.tls:
        try:
            client.tls_set(config.ca_file or None)
        except OSError as error:
            raise ConfigError(f'mqtt.ca_file {config.ca_file}: {error}') from error
    return client
