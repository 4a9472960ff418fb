"""Health of what is sent by a schedule: how much went out, was left out, and how late it was."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.ros.health.stream_health import PERIOD_S, status

_LATE_NS = 100_000_000
"""Delay that is a warning: two images and a half at 25 Hz."""


@dataclass(slots=True)
class ScheduleHealth:
    """
    How a schedule is kept.

    Attributes
    ----------
    doing : callable
        Returns what the node does now, in a word or two.
    sent, skipped : int
        What went out so far, and what was left out as it was too late.
    worst_ns : int
        How late the latest of this second was.

    """

    doing: Callable[[], str]
    sent: int = 0
    skipped: int = 0
    worst_ns: int = 0
    _before: tuple[int, int] = (0, 0)

    def add(self, behind_ns: int) -> None:
        """Count what was sent, so late."""
        self.sent += 1
        self.worst_ns = max(self.worst_ns, behind_ns)

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state of the last second and begin the next: a late schedule is a warning."""
        sent, skipped = self.sent - self._before[0], self.skipped - self._before[1]
        late_ms = self.worst_ns / 1e6
        self._before, self.worst_ns = (self.sent, self.skipped), 0
        parts = [self.doing()]
        if skipped:
            parts.append(f'{skipped} skipped')
        if late_ms * 1e6 > _LATE_NS:
            parts.append(f'{late_ms:.0f} ms late')
        values = {
            'rate [Hz]': f'{sent / PERIOD_S:.1f}',
            'sent': self.sent,
            'skipped': self.skipped,
            'worst delay [ms]': f'{late_ms:.1f}',
        }
        level = DiagnosticStatus.WARN if len(parts) > 1 else DiagnosticStatus.OK
        return status(name, level, '; '.join(parts), values)
