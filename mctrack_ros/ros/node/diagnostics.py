"""Health of a node's parts, on `/diagnostics` once a second."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.lifecycle import LifecyclePublisher

from mctrack_ros.codec import header
from mctrack_ros.ros.health.stream_health import PERIOD_S, StreamHealth, status
from mctrack_ros.ros.node.lifecycle import GraphNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

DIAGNOSTICS = '/diagnostics'
"""The topic."""
_HEARD = Duration(seconds=0.3)
"""How long a node that ends waits until its last words are heard."""


class Health(Protocol):
    """A part of a node whose state is reported."""

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state."""
        ...


def stream_health(node: GraphNode) -> StreamHealth:
    """Return the health of a stream of a node that has `DiagnosticsConfig` as `diagnostics`."""
    simulated = bool(node.get_parameter('use_sim_time').value)
    return StreamHealth(lambda: node.config.diagnostics, not simulated)


class Failure:
    """Why the node ends, if it does because something failed."""

    def __init__(self, node: GraphNode) -> None:
        self._node = node

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state."""
        failure = self._node.failure
        level = DiagnosticStatus.ERROR if failure else DiagnosticStatus.OK
        return status(name, level, failure or 'running', {})


class Diagnostics:
    """
    Publish the health of a node's parts once a second.

    A status is called ``<node>: <part>``, with the node's fully qualified name, as
    ``diagnostic_updater`` does it; its hardware is the camera, in the node's namespace.

    Parameters
    ----------
    node : GraphNode
        Opened just now; its `start` calls `begin`.
    parts : mapping of str to Health
        By name; of those that are about a camera, the first word is the camera's.
    cameras : collection of str
        Names of the cameras.

    """

    def __init__(
        self, node: GraphNode, parts: Mapping[str, Health], cameras: Collection[str]
    ) -> None:
        self._node = node
        self._parts = {**parts, 'exceptions': node.exceptions}
        self._failure = Failure(node)
        node.last_words = self.say_why
        self._cameras = cameras
        self._publisher: LifecyclePublisher = node.publisher(
            DiagnosticArray, DIAGNOSTICS, reliable(10)
        )

    def begin(self) -> None:
        """Start the timer; the node destroys it when it is deactivated."""
        self._node.every(PERIOD_S, self.publish)

    def publish(self) -> None:
        """Report now."""
        self._send(self._parts)

    def say_why(self) -> None:
        """Report at once why the node ends, and wait until it is heard."""
        self._send({'node': self._failure})
        self._publisher.wait_for_all_acked(_HEARD)

    def _send(self, parts: Mapping[str, Health]) -> None:
        stamp_ns = self._node.get_clock().now().nanoseconds
        self._publisher.publish(
            DiagnosticArray(
                header=header(RCLPY_CLASSES, stamp_ns, ''),
                status=[self._status(part, health) for part, health in parts.items()],
            )
        )

    def _status(self, part: str, health: Health) -> DiagnosticStatus:
        node = self._node.get_fully_qualified_name()
        status = health.report(f'{node}: {part}')
        camera = part.split()[0]
        namespace = self._node.get_namespace().rstrip('/')
        status.hardware_id = f'{namespace}/{camera}' if camera in self._cameras else node
        return status
