"""What the figures of a demo should reach, and how a target is stated."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Target:
    """
    What a figure is held against.

    Attributes
    ----------
    experiment : str
        Name of the figures it is in.
    figure : str
        Its dotted name there.
    label : str
        What it is, with its unit.
    least, most : float or None
        Bounds to reach; both `None`: the figure is only reported.
    anchor : str
        What a peer reaches on the same, or what is known about it.

    """

    experiment: str
    figure: str
    label: str
    least: float | None = None
    most: float | None = None
    anchor: str = ''

    @property
    def text(self) -> str:
        """Return the bound as people write it."""
        if self.least is not None:
            return f'≥ {self.least:g}'
        return '' if self.most is None else f'≤ {self.most:g}'

    def is_met(self, value: float) -> bool | None:
        """Return whether a value, rounded to three decimals, reaches the bound."""
        if self.least is None and self.most is None:
            return None
        if not math.isfinite(value):
            return False
        shown = round(value, 3)
        above = self.least is None or shown >= self.least
        return above and (self.most is None or shown <= self.most)


DEMO_TARGETS = (
    Target('demo', 'mota', 'MOTA at 1 m', least=0.85),
    Target('demo', 'idf1', 'IDF1 at 1 m', least=0.80),
    Target('demo', 'hota', 'HOTA'),
    Target('demo', 'moda', 'MODA at 1 m'),
    Target('demo', 'position_error_m', 'mean position error, m'),
    Target('demo', 'latency_p50_ms', 'latency, median, ms', most=30),
    Target('demo', 'latency_p99_ms', 'latency, 99th percentile, ms', most=80),
    Target('demo', 'realtime_factor', 'real-time factor', least=1.0),
    Target('demo', 'late_ticks', 'late ticks after 2 s', most=0),
    Target('demo', 'dropped_detections', 'detections dropped after 2 s', most=0),
)
