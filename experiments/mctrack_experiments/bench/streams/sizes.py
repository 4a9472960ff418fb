"""How many bytes a second a stream takes on the wire."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Sequence
from itertools import cycle, islice

from mctrack_experiments.bench.store import RATE_HZ
from mctrack_ros.interfaces import Tracks
from mctrack_ros.streams.formats import onvif
from mctrack_ros.streams.formats.geo import GeoReference
from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.frames import About, Assembler, Frame
from mctrack_ros.streams.mqtt import MqttConfig
from mctrack_ros.streams.serve.hub import MOST_WAITING, Hub
from mctrack_ros.streams.serve.server import Place, StreamServer

SECONDS = 10
GEO = GeoReference(52.5145, 13.2395, 30.0)
_BEGAN_NS = 1_700_000_000_000_000_000
_PATIENCE_S = 60.0
_REQUESTS = {
    'http': 'GET /{name} HTTP/1.1\r\nHost: localhost\r\nAccept-Encoding: gzip\r\n\r\n',
    'socket': 'GET /{name} HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\n'
    'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
    'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
    'Sec-WebSocket-Extensions: permessage-deflate\r\n\r\n',
}


def measure_sizes(tape: Sequence[Tracks]) -> dict[str, float]:
    """
    Return kB a second, headers included, of each form by HTTP and web socket; of MQTT at its rate.

    Parameters
    ----------
    tape : sequence of Tracks
        Messages of tracks, played forwards again and again.

    """
    frames = _frames(tape)
    figures = {}
    for way, request in _REQUESTS.items():
        for profile in all_profiles(GEO):
            size = _bytes_read(request.format(name=profile.name).encode(), frames)
            figures[f'{way}.{profile.name.replace(".", "_")}.kb_per_s'] = size / SECONDS / 1e3
    payloads = [len(onvif.json_frame(frame, GEO)) for frame in frames]
    broker = MqttConfig()
    per_frame = sum(payloads) / len(payloads) + len(onvif.metadata_topic(broker.prefix))
    figures['mqtt.kb_per_s'] = per_frame * broker.rate / 1e3
    return figures


def _frames(tape: Sequence[Tracks]) -> list[Frame]:
    assembler, frames = Assembler(About()), []
    for tick, tracks in enumerate(islice(cycle(tape), SECONDS * RATE_HZ)):
        assembler.add_tracks(tracks.at(_BEGAN_NS + tick * 1_000_000_000 // RATE_HZ))
        frame = assembler.finish()
        assert frame is not None
        frames.append(frame)
    return frames


def _bytes_read(request: bytes, frames: Sequence[Frame]) -> int:
    """Return how many bytes a reader is sent until the stream ends."""
    hub = Hub(all_profiles(GEO), 0.0, 1)
    with StreamServer(hub, Place(), 1) as server:
        server.start()
        hub.describe(About('bench'))
        with socket.create_connection(('127.0.0.1', server.port), _PATIENCE_S) as reader:
            reader.sendall(request)
            count = [0]
            reading = threading.Thread(target=_read, args=(reader, count))
            reading.start()
            end = time.monotonic() + _PATIENCE_S
            while not (hub.count and count[0]):
                if time.monotonic() > end:
                    raise TimeoutError('the stream did not begin')
                time.sleep(0.01)
            for number, frame in enumerate(frames):
                hub.publish(frame)
                if number % (MOST_WAITING // 2) == 0:
                    time.sleep(0.2)
            time.sleep(0.5)
            server.loop.call_soon_threadsafe(hub.end)
            reading.join(_PATIENCE_S)
    return count[0]


def _read(reader: socket.socket, count: list[int]) -> None:
    while part := reader.recv(65536):
        count[0] += len(part)
