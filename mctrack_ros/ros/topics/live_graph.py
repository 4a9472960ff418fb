"""What a running graph says of tracks, events and cameras, for a page."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from sensor_msgs.msg import CompressedImage, Image, PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import (
    CodecError,
    image_from_message,
    jpeg_from_image,
    rows_from_cloud,
    stamp_ns_of,
)
from mctrack_ros.interfaces import Detections, Events, Tracks
from mctrack_ros.ros.topics import quality

_LEAST_GAP_NS = 120_000_000
"""Between images of a camera that are shown: about eight a second."""
_MOST_BYTES = 8_000_000
"""Larger images are not shown."""
_WAITING = 4
"""Images of a camera that wait for their detections."""


@dataclass(frozen=True, slots=True)
class Status:
    """
    A part's state, from `/diagnostics`.

    Attributes
    ----------
    name : str
        ``<node>: <part>``.
    hardware : str
        The camera with its namespace, or the node.
    level : int
        0 good, 1 warning, 2 error, 3 stale.
    message : str
        Why.
    values : mapping of str to str
        By name, for example ``rate [Hz]``.

    """

    name: str
    hardware: str
    level: int
    message: str
    values: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class CameraImage:
    """
    An image of a camera.

    Attributes
    ----------
    camera : str
        Whose.
    stamp_ns : int
        Of the image, ns.
    data : bytes
        JPEG or PNG.
    detections : Detections or None
        What was found in it, as far as that came in time.

    """

    camera: str
    stamp_ns: int
    data: bytes
    detections: Detections | None = None


class Listener(Protocol):
    """Called with each message, in the graph's thread."""

    def heard_tracks(self, tracks: Tracks) -> None:
        """Take a message of `/tracks`."""
        ...

    def heard_events(self, events: Events) -> None:
        """Take a message of `/events`."""
        ...

    def heard_site(self, description: Mapping[str, Any]) -> None:
        """Take what `/site` says."""
        ...

    def heard_health(self, statuses: list[Status]) -> None:
        """Take a message of `/diagnostics`."""
        ...

    def received_image(self, image: CameraImage) -> None:
        """Take an image of a camera that is shown."""
        ...


@dataclass(slots=True)
class _Shown:
    """A camera whose images are shown: they wait for the detections of the same stamp."""

    subscriptions: list[Subscription[Any]] = field(default_factory=list)
    waiting: OrderedDict[int, Any] = field(default_factory=OrderedDict)
    last_ns: int = 0


class LiveGraph:
    """
    Subscribe to what a site's graph publishes, in a thread of its own.

    Tracks are taken best effort: a page that is slow holds up nobody.

    Parameters
    ----------
    listener : Listener
        Who is told.
    namespace : str
        Of the graph, as ``/hall``; empty: none.
    image_topics : mapping of str to str
        Whole name of the topic of images by camera; others' are not shown.
    domain : int, optional
        ROS domain; by default that of the environment.

    """

    def __init__(
        self,
        listener: Listener,
        namespace: str = '',
        image_topics: Mapping[str, str] | None = None,
        domain: int | None = None,
    ) -> None:
        self._listener, self._namespace = listener, namespace
        self._image_topics = dict(image_topics or {})
        self._shown: dict[str, _Shown] = {}
        self._context = Context()
        rclpy.init(
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self._node = rclpy.create_node('mctrack_map', namespace=namespace, context=self._context)
        newest = QoSProfile(depth=2, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._hear(PointCloud2, 'tracks', self._on_tracks, newest)
        self._hear(PointCloud2, 'events', self._on_events, quality.reliable(100))
        self._hear(String, 'site', self._on_site, quality.latched())
        self._hear(DiagnosticArray, '/diagnostics', self._on_health, quality.reliable(50))
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name='live graph', daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave the graph."""
        self._context.try_shutdown()
        self._thread.join()
        self._node.destroy_node()

    def show(self, cameras: set[str]) -> None:
        """Take the images of these cameras from now on, and of no others."""
        self._executor.create_task(self._show, cameras & self._image_topics.keys())

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    def _hear(self, kind: Any, topic: str, heard: Any, profile: QoSProfile) -> Subscription[Any]:
        return self._node.create_subscription(
            kind, topic, heard, profile,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )  # fmt: skip

    def _on_tracks(self, message: PointCloud2) -> None:
        try:
            tracks = rows_from_cloud(message, Tracks)
        except CodecError:
            return
        self._listener.heard_tracks(tracks)

    def _on_events(self, message: PointCloud2) -> None:
        try:
            events = rows_from_cloud(message, Events)
        except CodecError:
            return
        if len(events):
            self._listener.heard_events(events)

    def _on_site(self, message: String) -> None:
        try:
            description = json.loads(message.data)
        except ValueError:
            return
        if isinstance(description, dict):
            self._listener.heard_site(description)

    def _on_health(self, message: DiagnosticArray) -> None:
        self._listener.heard_health(
            [
                Status(
                    each.name,
                    each.hardware_id,
                    ord(each.level),
                    each.message,
                    {value.key: value.value for value in each.values},
                )
                for each in message.status
            ]
        )

    def _show(self, cameras: set[str]) -> None:
        for camera in self._shown.keys() - cameras:
            for subscription in self._shown.pop(camera).subscriptions:
                self._node.destroy_subscription(subscription)
        for camera in cameras - self._shown.keys():
            shown = self._shown[camera] = _Shown()
            topic = self._image_topics[camera]
            kind = CompressedImage if topic.endswith('/compressed') else Image
            below = f'{self._namespace}/{camera}/{Detections.TOPIC}'
            newest = quality.images(False, 1)
            shown.subscriptions = [
                self._hear(kind, topic, lambda m, c=camera: self._on_image(c, m), newest),
                self._hear(PointCloud2, below, lambda m, c=camera: self._on_found(c, m), newest),
            ]

    def _on_image(self, camera: str, message: Any) -> None:
        shown = self._shown.get(camera)
        if shown is None or len(message.data) > _MOST_BYTES:
            return
        shown.waiting[stamp_ns_of(message)] = message
        if len(shown.waiting) > _WAITING:
            stamp_ns, oldest = shown.waiting.popitem(last=False)
            self._tell(camera, shown, stamp_ns, oldest, None)

    def _on_found(self, camera: str, message: PointCloud2) -> None:
        shown = self._shown.get(camera)
        if shown is None:
            return
        image = shown.waiting.pop(stamp_ns_of(message), None)
        if image is None:
            return
        try:
            found = rows_from_cloud(message, Detections)
        except CodecError:
            return
        for stamp_ns in [each for each in shown.waiting if each < found.stamp_ns]:
            del shown.waiting[stamp_ns]
        self._tell(camera, shown, found.stamp_ns, image, found)

    def _tell(
        self, camera: str, shown: _Shown, stamp_ns: int, image: Any, found: Detections | None
    ) -> None:
        if abs(stamp_ns - shown.last_ns) < _LEAST_GAP_NS:
            return
        shown.last_ns = stamp_ns
        try:
            data = _compressed(image)
        except CodecError:
            return
        self._listener.received_image(CameraImage(camera, stamp_ns, data, found))


def _compressed(message: Any) -> bytes:
    """Return an image as JPEG or PNG; a compressed one as it came."""
    if hasattr(message, 'encoding'):
        return jpeg_from_image(image_from_message(message)).tobytes()
    return np.frombuffer(message.data, np.uint8).tobytes()
