"""Images of a running graph, for a page: which topics hold them, and the next of one."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CompressedImage, Image

from mctrack_ros.ros.topics import quality

KINDS = {'sensor_msgs/msg/Image': Image, 'sensor_msgs/msg/CompressedImage': CompressedImage}
_LOOK_AROUND_S = 1.5
"""How long topics are collected after the first, s: they are not found all at once."""
_WAKE_S = 0.05


class LiveImages:
    """The topics of images that somebody publishes now; a context manager."""

    def __enter__(self) -> Self:
        """Join the graph."""
        self._context = Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node('mctrack_images', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave it."""
        self._node.destroy_node()
        self._context.try_shutdown()

    @property
    def name(self) -> str:
        """How messages call the graph."""
        return f'the graph of ROS domain {os.environ.get("ROS_DOMAIN_ID") or 0}'

    def topics(self, patience_s: float) -> dict[str, str]:
        """Return the type by name of the topics of images; empty if none appears in time."""
        self._spin_until(lambda: bool(self._published()), patience_s)
        self._spin_until(lambda: False, _LOOK_AROUND_S)
        return self._published()

    def wait_for(self, topic: str, patience_s: float) -> str | None:
        """Return the type of a topic as soon as somebody publishes it; None if nobody does."""
        self._spin_until(lambda: self._node.count_publishers(topic) > 0, patience_s)
        offers = self._node.get_publishers_info_by_topic(topic)
        return str(offers[0].topic_type) if offers else None

    def next(self, topic: str, kind: str, patience_s: float) -> Any:
        """Return the next message of a topic of one of `KINDS`; None if none comes."""
        received: list[Any] = []
        best_effort = quality.images(False, 1)
        self._node.create_subscription(KINDS[kind], topic, received.append, best_effort)
        self._spin_until(lambda: bool(received), patience_s)
        return received[0] if received else None

    def _published(self) -> dict[str, str]:
        return {
            name: kinds[0]
            for name, kinds in self._node.get_topic_names_and_types()
            if kinds[0] in KINDS and self._node.count_publishers(name)
        }

    def _spin_until(self, condition: Callable[[], bool], patience_s: float) -> None:
        end = time.monotonic() + patience_s
        while not condition() and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=_WAKE_S)
