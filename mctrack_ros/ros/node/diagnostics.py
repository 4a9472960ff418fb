"""Health of a node's streams and of its other parts, on `/diagnostics` once a second."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from statistics import fmean, median
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.lifecycle import LifecyclePublisher

from mctrack_ros.codec import header
from mctrack_ros.interfaces import RESTART_NS
from mctrack_ros.ros.node.lifecycle import GraphNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

_PERIOD_S = 1.0
_PAUSE_NS = 10_000_000_000
"""A longer gap is a pause, not a loss of messages."""
_GAPS = 25
"""Number of gaps whose median is the interval of a stream."""
_FEWEST_GAPS = 3
_IRREGULAR = 0.15
"""Mean deviation from whole intervals above which a stream is irregular: no loss is counted."""


@dataclass(slots=True)
class StreamHealth:
    """
    Counts of one stream; those of the last second are reported, then begun anew.

    Attributes
    ----------
    received, latency_ns, worst_ns : int
        Messages since the last report, the sum and the largest of their ages on arrival.
    last_stamp_ns : int or None
        Of the newest message.
    gaps_ns : deque of int
        Between the stamps of the last messages.
    totals : dict of str to int
        What went wrong since the start, by kind: ``late``, ``lost``, ``refused`` ...
    reported : dict of str to int
        The same at the last report.

    """

    received: int = 0
    latency_ns: int = 0
    worst_ns: int = 0
    last_stamp_ns: int | None = None
    gaps_ns: deque[int] = field(default_factory=lambda: deque(maxlen=_GAPS))
    totals: dict[str, int] = field(default_factory=dict)
    reported: dict[str, int] = field(default_factory=dict)

    def arrived(self, stamp_ns: int, now_ns: int) -> None:
        """Count a message, and the messages lost in the gap before it."""
        self.received += 1
        self.latency_ns += now_ns - stamp_ns
        self.worst_ns = max(self.worst_ns, now_ns - stamp_ns)
        gap_ns = _PAUSE_NS if self.last_stamp_ns is None else stamp_ns - self.last_stamp_ns
        if -RESTART_NS < gap_ns <= 0:
            return
        self.last_stamp_ns = stamp_ns
        if 0 < gap_ns < _PAUSE_NS:
            self.gaps_ns.append(gap_ns)
            lost = self._lost_in(gap_ns)
            if lost:
                self.count('lost', lost)

    def _lost_in(self, gap_ns: int) -> int:
        """Return how many messages were lost in a gap."""
        interval_ns = median(self.gaps_ns)
        lost = round(gap_ns / interval_ns) - 1
        return lost if lost > 0 and self._is_regular(interval_ns) else 0

    def _is_regular(self, interval_ns: float) -> bool:
        """Tell whether messages come at a steady interval, losses aside."""
        periods = [gap_ns / interval_ns for gap_ns in self.gaps_ns]
        error = fmean(abs(each - max(round(each), 1)) for each in periods)
        return len(periods) >= _FEWEST_GAPS and error < _IRREGULAR

    def _interval_text(self) -> str:
        """Return the interval of the stream in milliseconds, if it has one."""
        if len(self.gaps_ns) < _FEWEST_GAPS:
            return 'not known yet'
        interval_ns = median(self.gaps_ns)
        return f'{interval_ns / 1e6:.1f}' if self._is_regular(interval_ns) else 'irregular'

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
            'interval [ms]': self._interval_text(),
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
    """A part of a node whose state is reported."""

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state."""
        ...


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
        self._cameras = cameras
        self._publisher: LifecyclePublisher = node.publisher(
            DiagnosticArray, '/diagnostics', reliable(10)
        )

    def begin(self) -> None:
        """Start the timer; the node destroys it when it is deactivated."""
        self._node.every(_PERIOD_S, self.publish)

    def publish(self) -> None:
        """Report now."""
        stamp_ns = self._node.get_clock().now().nanoseconds
        self._publisher.publish(
            DiagnosticArray(
                header=header(RCLPY_CLASSES, stamp_ns, ''),
                status=[self._status(part, health) for part, health in self._parts.items()],
            )
        )

    def _status(self, part: str, health: Health) -> DiagnosticStatus:
        node = self._node.get_fully_qualified_name()
        status = health.report(f'{node}: {part}')
        camera = part.split()[0]
        namespace = self._node.get_namespace().rstrip('/')
        status.hardware_id = f'{namespace}/{camera}' if camera in self._cameras else node
        return status
