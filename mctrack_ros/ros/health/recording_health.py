"""Health of a recording: what it has, what it lost, and how long the disk lasts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.ros.health.stream_health import PERIOD_S, status

_SOON_S = 600.0
"""A disk that will be full so soon is a warning."""


class Recorded(NamedTuple):
    """
    How far a recording is.

    Attributes
    ----------
    topics, messages, size, lost, left_out : int
        Topics that are recorded; messages and bytes so far; messages that did not come; topics
        that cannot be recorded.
    room : int
        Bytes that may still be written.

    """

    topics: int
    messages: int
    size: int
    lost: int
    left_out: int
    room: int


@dataclass(slots=True)
class RecordingHealth:
    """
    How a recording goes.

    Attributes
    ----------
    now : callable
        Returns how far it is.
    before : Recorded
        The same at the last report.

    """

    now: Callable[[], Recorded]
    before: Recorded = field(default_factory=lambda: Recorded(*[0] * 6))

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: lost messages are a warning, and a disk that is nearly full."""
        now, before = self.now(), self.before
        self.before = now
        rate = (now.size - before.size) / PERIOD_S
        left_s = now.room / rate if rate > 0 else math.inf
        level, parts = DiagnosticStatus.OK, ['recording' if now.topics else 'no topic yet']
        if now.lost > before.lost:
            parts.append(f'{now.lost - before.lost} messages were lost')
        if left_s < _SOON_S:
            parts.append(f'the disk will be full in {left_s:.0f} s')
        if len(parts) > 1:
            level = DiagnosticStatus.WARN
        values = {
            'topics': now.topics,
            'messages': now.messages,
            'rate [Hz]': f'{(now.messages - before.messages) / PERIOD_S:.1f}',
            'written [MB/s]': f'{rate / 1e6:.3f}',
            'size [MB]': f'{now.size / 1e6:.3f}',
            'lost': now.lost,
            'topics left out': now.left_out,
            'room [MB]': f'{now.room / 1e6:.0f}',
        }
        return status(name, level, '; '.join(parts), values)
