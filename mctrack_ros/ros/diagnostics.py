"""Health of a node's streams and of its other parts, on `/diagnostics` once a second."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.lifecycle import LifecyclePublisher

from mctrack_ros.codec import header
from mctrack_ros.ros.lifecycle import GraphNode
from mctrack_ros.ros.messages import RCLPY_CLASSES
from mctrack_ros.ros.quality import reliable

_PERIOD_S = 1.0
_PAUSE_NS = 10_000_000_000
"""A stream that is silent for so long has stopped; it has not lost all that."""


@dataclass(slots=True)
class StreamHealth:
    """
    Counts of one stream; those of the last second are reported, then begun anew.

    Attributes
    ----------
    received, latency_ns, worst_ns : int
        Messages since the last report, the sum and the largest of their ages on arrival.
    last_stamp_ns, interval_ns : int
        Of the newest message, and between messages when none is lost.
    totals : dict of str to int
        What went wrong since the start, by kind: ``late``, ``lost``, ``refused`` ...
    reported : dict of str to int
        The same at the last report.

    """

    received: int = 0
    latency_ns: int = 0
    worst_ns: int = 0
    last_stamp_ns: int = 0
    interval_ns: int = 0
    totals: dict[str, int] = field(default_factory=dict)
    reported: dict[str, int] = field(default_factory=dict)

    def arrived(self, stamp_ns: int, now_ns: int) -> None:
        """Count a message, and those that the gap before it shows to be lost."""
        self.received += 1
        self.latency_ns += now_ns - stamp_ns
        self.worst_ns = max(self.worst_ns, now_ns - stamp_ns)
        gap_ns, self.last_stamp_ns = stamp_ns - self.last_stamp_ns, stamp_ns
        if 0 < gap_ns < _PAUSE_NS:
            self.interval_ns = min(gap_ns, self.interval_ns or gap_ns)
            lost = round(gap_ns / self.interval_ns) - 1
            if lost:
                self.count('lost', lost)

    def count(self, kind: str, number: int = 1) -> None:
        """Count what went wrong."""
        self.totals[kind] = self.totals.get(kind, 0) + number

    def report(self, name: str) -> DiagnosticStatus:
        """
        Return the state of the last second and begin the next.

        A warning if anything went wrong in it, an error if nothing could be used.
        """
        mean_ns = self.latency_ns / max(self.received, 1)
        values = {
            'rate [Hz]': f'{self.received / _PERIOD_S:.1f}',
            'mean latency [ms]': f'{mean_ns / 1e6:.1f}',
            'worst latency [ms]': f'{self.worst_ns / 1e6:.1f}',
            **{kind: str(number) for kind, number in self.totals.items()},
        }
        level, message = self._judged()
        status = DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )
        self.received = self.latency_ns = self.worst_ns = 0
        self.reported = self.totals.copy()
        return status

    def _judged(self) -> tuple[bytes, str]:
        """Return the level of the last second, and why."""
        if self.received == 0:
            return DiagnosticStatus.STALE, 'no data'
        new = {
            kind: number - self.reported.get(kind, 0)
            for kind, number in self.totals.items()
            if number > self.reported.get(kind, 0)
        }
        if not new:
            return DiagnosticStatus.OK, 'receiving'
        message = 'receiving; ' + ', '.join(f'{number} {kind}' for kind, number in new.items())
        is_useless = new.get('refused', 0) >= self.received
        return DiagnosticStatus.ERROR if is_useless else DiagnosticStatus.WARN, message


class Health(Protocol):
    """What is reported under one name."""

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state."""
        ...


class Diagnostics:
    """
    Publish the health of a node's parts once a second.

    Parameters
    ----------
    node : GraphNode
        Opened just now; its `start` calls `begin`.
    parts : mapping of str to Health
        By name.

    """

    def __init__(self, node: GraphNode, parts: Mapping[str, Health]) -> None:
        self._node = node
        self._parts = {**parts, 'exceptions': node.exceptions}
        self._publisher: LifecyclePublisher = node.publisher(
            DiagnosticArray, '/diagnostics', reliable(10)
        )

    def begin(self) -> None:
        """Start the timer; the node destroys it when it is deactivated."""
        self._node.every(_PERIOD_S, self.publish)

    def publish(self) -> None:
        """Report now."""
        stamp_ns = self._node.get_clock().now().nanoseconds
        name = self._node.get_name()
        self._publisher.publish(
            DiagnosticArray(
                header=header(RCLPY_CLASSES, stamp_ns, ''),
                status=[health.report(f'{name}: {part}') for part, health in self._parts.items()],
            )
        )
