"""Health of fusion's tracking: how late it is, and what its gates let through."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.fusion import FusionOutput
from mctrack_ros.ros.health.stream_health import PERIOD_S, Latencies, Levels, status


@dataclass(slots=True)
class TrackingHealth:
    """
    What the ticks of the last second gave.

    Attributes
    ----------
    levels : callable
        Returns what is a warning, and what an error.
    publishing : Latencies
        From the stamp of a tick until its tracks were published.
    ticks, tracks, detections, unassigned : int
        Sums over these ticks; unassigned are detections that lie in the gate of no track, or that
        others took from them.

    """

    levels: Levels
    publishing: Latencies = field(default_factory=Latencies)
    ticks: int = 0
    tracks: int = 0
    detections: int = 0
    unassigned: int = 0

    def published(self, output: FusionOutput, now_ns: int) -> None:
        """Take notice of a tick."""
        self.publishing.add(output.tracks.stamp_ns, now_ns)
        self.ticks += 1
        self.tracks += len(output.tracks)
        self.detections += output.detections
        self.unassigned += output.unassigned

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state of the last second and begin the next: late tracks are a warning."""
        assigned = math.nan
        if self.detections:
            assigned = 100.0 * (1.0 - self.unassigned / self.detections)
        ticks = max(self.ticks, 1)
        values = {
            'ticks [Hz]': f'{self.ticks / PERIOD_S:.1f}',
            **self.publishing.values('publish latency'),
            'tracks': f'{self.tracks / ticks:.1f}',
            'detections a tick': f'{self.detections / ticks:.1f}',
            'assigned to tracks [%]': f'{assigned:.1f}',
        }
        level, why = self.publishing.judged(self.levels())
        message = f'tracks are published {why}' if why else 'tracking'
        if not self.ticks:
            level, message = DiagnosticStatus.STALE, 'no tick: no camera reports'
        self.publishing.ages_ns.clear()
        self.ticks = self.tracks = self.detections = self.unassigned = 0
        return status(name, level, message, values)
