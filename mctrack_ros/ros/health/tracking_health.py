"""Health of fusion's tracking: how late it is, and what its gates let through."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.fusion import FusionOutput, Gates
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
    cameras : tuple of str
        In the site's order.
    ticks, tracks : int
        Sums over these ticks.
    gates : list of Gates
        Of these ticks.

    """

    levels: Levels
    cameras: tuple[str, ...] = ()
    publishing: Latencies = field(default_factory=Latencies)
    ticks: int = 0
    tracks: int = 0
    gates: list[Gates] = field(default_factory=list)

    def published(self, output: FusionOutput, now_ns: int) -> None:
        """Take notice of a tick."""
        self.publishing.add(output.tracks.stamp_ns, now_ns)
        self.ticks += 1
        self.tracks += len(output.tracks)
        if output.gates is not None:
            self.gates.append(output.gates)

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state of the last second and begin the next: late tracks are a warning."""
        ticks = max(self.ticks, 1)
        values = {
            'ticks [Hz]': f'{self.ticks / PERIOD_S:.1f}',
            **self.publishing.values('publish latency'),
            'tracks': f'{self.tracks / ticks:.1f}',
            **self._gate_values(ticks),
        }
        level, why = self.publishing.judged(self.levels())
        message = f'tracks are published {why}' if why else 'tracking'
        if not self.ticks:
            level, message = DiagnosticStatus.STALE, 'no tick: no camera reports'
        self.publishing.ages_ns.clear()
        self.gates.clear()
        self.ticks = self.tracks = 0
        return status(name, level, message, values)

    def _gate_values(self, ticks: int) -> dict[str, str]:
        """Return what became of detections, of all cameras and by camera."""
        none = np.zeros(len(self.cameras), np.int64)
        everything = sum((each.detections for each in self.gates), none)
        outside = sum((each.in_no_gate for each in self.gates), none)
        passed_over = sum((each.taken_by_others for each in self.gates), none)
        left = outside + passed_over
        shares = dict(zip(self.cameras, map(_assigned, everything, left)))
        return {
            'detections a tick': f'{everything.sum() / ticks:.1f}',
            'assigned to tracks [%]': _assigned(everything.sum(), left.sum()),
            'in no gate a tick': f'{outside.sum() / ticks:.1f}',
            'taken by others a tick': f'{passed_over.sum() / ticks:.1f}',
            **{f'{camera} assigned [%]': share for camera, share in shares.items()},
        }


def _assigned(detections: int, left: int) -> str:
    """Return the share of detections that tracks took, %; NaN: there are none."""
    return f'{100.0 * (1.0 - left / detections) if detections else math.nan:.1f}'
