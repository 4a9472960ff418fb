"""Health of a stream of messages: rate, latency, and what is lost, late, twice or refused."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from statistics import fmean, median

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.config import parameter
from mctrack_ros.interfaces import starts_anew

PERIOD_S = 1.0
"""Between two reports."""
_PAUSE_NS = 10_000_000_000
"""A longer gap is a pause, not a loss of messages."""
_GAPS = 25
"""Number of gaps whose median is the interval of a stream."""
_FEWEST_GAPS = 3
_IRREGULAR = 0.15
"""Mean deviation from whole intervals above which a stream is irregular: no loss is counted."""
_OTHER_CLOCK_NS = 60_000_000_000
"""A message is not that old: its stamps are of another clock, a bag's for example."""
_SILENT_S = 0.6
"""A stream is silent after so long, and after three of its intervals."""
_SLACK = 1.5
"""Difference in messages a second that only depends on when the second begins."""
_COUNTS = ('lost', 'late', 'refused')
"""What is reported of every stream, even if there is none."""
_LOSSES = ('lost', 'late', 'refused', 'duplicate', 'out of order')
"""What is wrong with a message itself, and judged by its share; all else is a warning."""


@dataclass(frozen=True, slots=True)
class LatencyLevels:
    """Latency from capture to publishing, 99 % of the last second."""

    warning: float = parameter(
        0.3,
        'Latency from capture to publishing, 99 % of the last second, that is a warning [s]',
        minimum=0.0,
        maximum=60.0,
        at_run_time=True,
    )
    error: float = parameter(
        1.0, 'The same for an error [s]', minimum=0.0, maximum=60.0, at_run_time=True
    )


@dataclass(frozen=True, slots=True)
class RateLevels:
    """Share of the expected rate at which messages come in."""

    warning: float = parameter(
        0.9,
        'Share of the expected rate below which a stream is a warning',
        minimum=0.0,
        maximum=1.0,
        at_run_time=True,
    )
    error: float = parameter(
        0.5, 'The same for an error', minimum=0.0, maximum=1.0, at_run_time=True
    )
    expected: float = parameter(
        0.0,
        'Rate that is expected; 0: the highest that the stream has kept so far [Hz]',
        minimum=0.0,
        maximum=1000.0,
        at_run_time=True,
    )


@dataclass(frozen=True, slots=True)
class LossLevels:
    """Share of a second's messages that are lost, late, twice, out of order or refused."""

    warning: float = parameter(
        0.0,
        'Share of messages lost, late, twice, out of order or refused above which a stream is a '
        'warning',
        minimum=0.0,
        maximum=1.0,
        at_run_time=True,
    )
    error: float = parameter(
        1.0, 'Share from which it is an error', minimum=0.0, maximum=1.0, at_run_time=True
    )


@dataclass(frozen=True, slots=True)
class DiagnosticsConfig:
    """From when on diagnostics warn."""

    latency: LatencyLevels = LatencyLevels()
    rate: RateLevels = RateLevels()
    losses: LossLevels = LossLevels()


Levels = Callable[[], DiagnosticsConfig]
"""Returns the levels as they are set now."""


@dataclass(slots=True)
class Latencies:
    """
    How old messages were, since the last report.

    Attributes
    ----------
    ages_ns : list of int
        From capture until now, ns; none whose stamps are of another clock.

    """

    ages_ns: list[int] = field(default_factory=list)

    def add(self, stamp_ns: int, now_ns: int) -> None:
        """Take notice of a message."""
        if abs(now_ns - stamp_ns) < _OTHER_CLOCK_NS:
            self.ages_ns.append(now_ns - stamp_ns)

    def percentile(self, share: float) -> float:
        """Return the age that a share, %, does not exceed, ns; NaN: nothing came."""
        return float(np.percentile(self.ages_ns, share)) if self.ages_ns else math.nan

    def values(self, what: str) -> dict[str, str]:
        """Return median and 99 % by name, in milliseconds."""
        return {f'{what} p{share} [ms]': _ms(self.percentile(share)) for share in (50, 99)}

    def judged(self, levels: DiagnosticsConfig) -> tuple[bytes, str]:
        """Return the level, and why it is that."""
        worst_s = self.percentile(99) * 1e-9
        level = DiagnosticStatus.OK
        if worst_s > levels.latency.warning:
            level = DiagnosticStatus.WARN
        if worst_s > levels.latency.error:
            level = DiagnosticStatus.ERROR
        return level, f'{worst_s:.2f} s behind' if level != DiagnosticStatus.OK else ''


@dataclass(slots=True)
class StreamHealth:
    """
    Counts of one stream; those of the last second are reported, then begun anew.

    Attributes
    ----------
    levels : callable
        Returns what is a warning, and what an error.
    is_timed : bool
        Whether messages come as fast as their stamps: not if time is simulated.
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
    disorder : dict of str to int
        Messages since the start that came twice, or after later ones.
    shortest_ns : float
        Interval of the stream at its fastest, ns; NaN: not known yet.
    arrival, publishing : Latencies
        From capture until a message came in, and until what was made of it was published.

    """

    levels: Levels = DiagnosticsConfig
    is_timed: bool = True
    received: int = 0
    latency_ns: int = 0
    worst_ns: int = 0
    last_stamp_ns: int | None = None
    gaps_ns: deque[int] = field(default_factory=lambda: deque(maxlen=_GAPS))
    totals: dict[str, int] = field(default_factory=dict)
    reported: dict[str, int] = field(default_factory=dict)
    disorder: dict[str, int] = field(default_factory=lambda: {'duplicate': 0, 'out of order': 0})
    shortest_ns: float = math.nan
    arrival: Latencies = field(default_factory=Latencies)
    publishing: Latencies = field(default_factory=Latencies)
    _heard_s: float | None = None
    _is_new: bool = True
    _begun_s: float = field(default_factory=time.monotonic)

    def arrived(self, stamp_ns: int, now_ns: int) -> None:
        """Count a message, and the messages lost in the gap before it."""
        self.received += 1
        self._heard_s = time.monotonic()
        self.latency_ns += now_ns - stamp_ns
        self.worst_ns = max(self.worst_ns, now_ns - stamp_ns)
        self.arrival.add(stamp_ns, now_ns)
        gap_ns = _PAUSE_NS if self.last_stamp_ns is None else stamp_ns - self.last_stamp_ns
        if gap_ns <= 0 and not starts_anew(stamp_ns, self.last_stamp_ns):
            self.disorder['out of order' if gap_ns else 'duplicate'] += 1
            return
        self.last_stamp_ns = stamp_ns
        if 0 < gap_ns < _PAUSE_NS:
            self.gaps_ns.append(gap_ns)
            lost = self._lost_in(gap_ns)
            if lost:
                self.count('lost', lost)

    def published(self, stamp_ns: int, now_ns: int) -> None:
        """Take notice that what was made of a message was published."""
        self.publishing.add(stamp_ns, now_ns)

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

    def _interval_ns(self) -> float:
        """Return the interval of the stream, ns; NaN: it has none, or it is not known yet."""
        if len(self.gaps_ns) < _FEWEST_GAPS:
            return math.nan
        interval_ns = float(median(self.gaps_ns))
        return interval_ns if self._is_regular(interval_ns) else math.nan

    def _expected_ns(self) -> float:
        """Return the interval that is expected, ns; NaN: it is not known yet."""
        stated = self.levels().rate.expected
        return 1e9 / stated if stated else self.shortest_ns

    def _interval_text(self) -> str:
        """Return the interval of the stream in milliseconds, if it has one."""
        if len(self.gaps_ns) < _FEWEST_GAPS:
            return 'not known yet'
        interval_ns = self._interval_ns()
        return 'irregular' if math.isnan(interval_ns) else f'{interval_ns / 1e6:.1f}'

    def count(self, kind: str, number: int = 1) -> None:
        """Count what went wrong."""
        self.totals[kind] = self.totals.get(kind, 0) + number

    def report(self, name: str) -> DiagnosticStatus:
        """
        Return the state of the last second and begin the next.

        A warning if anything went wrong in it, an error if nothing could be used.
        """
        mean_ns = self.latency_ns / max(self.received, 1)
        if len(self.gaps_ns) == _GAPS:
            self.shortest_ns = float(np.fmin(self.shortest_ns, self._interval_ns()))
        values = {
            'rate [Hz]': f'{self.received / PERIOD_S:.1f}',
            'expected rate [Hz]': f'{1e9 / self._expected_ns():.1f}',
            'mean latency [ms]': f'{mean_ns / 1e6:.1f}',
            'worst latency [ms]': f'{self.worst_ns / 1e6:.1f}',
            **self.arrival.values('latency'),
            **(self.publishing.values('publish latency') if self.publishing.ages_ns else {}),
            'interval [ms]': self._interval_text(),
            **dict.fromkeys(_COUNTS, '0'),
            **_texts(self.disorder),
            **_texts(self.totals),
        }
        level, message = self._judged()
        self._begin()
        return status(name, level, message, values)

    def _begin(self) -> None:
        """Begin the next second."""
        self.received = self.latency_ns = self.worst_ns = 0
        self.arrival.ages_ns.clear()
        self.publishing.ages_ns.clear()
        self.reported = self.totals | self.disorder
        self._is_new, self._begun_s = self._heard_s is None, time.monotonic()

    def _judged(self) -> tuple[bytes, str]:
        """Return the level of the last second, and why."""
        if self.received == 0:
            return DiagnosticStatus.STALE, 'no data'
        silent_s = 0.0 if self._heard_s is None else time.monotonic() - self._heard_s
        if silent_s > max(_SILENT_S, 3e-9 * np.nan_to_num(self._interval_ns())):
            return DiagnosticStatus.STALE, f'no data for {silent_s:.1f} s'
        level, parts, levels = DiagnosticStatus.OK, ['receiving'], self.levels()
        latency = (self.publishing if self.publishing.ages_ns else self.arrival).judged(levels)
        for own, why in (self._judged_losses(levels), latency, self._judged_rate(levels)):
            level = max(level, own)
            parts += [why] if why else []
        return level, '; '.join(parts)

    def _judged_losses(self, levels: DiagnosticsConfig) -> tuple[bytes, str]:
        """Return the level of what went wrong, and what did."""
        new = {
            kind: number - self.reported.get(kind, 0)
            for kind, number in (self.totals | self.disorder).items()
            if number > self.reported.get(kind, 0)
        }
        wrong = sum(new.get(kind, 0) for kind in _LOSSES)
        share = wrong / (self.received + new.get('lost', 0))
        if share <= levels.losses.warning:
            new = {kind: number for kind, number in new.items() if kind not in _LOSSES}
        if not new:
            return DiagnosticStatus.OK, ''
        is_error = wrong > 0 and share >= levels.losses.error
        level = DiagnosticStatus.ERROR if is_error else DiagnosticStatus.WARN
        return level, ', '.join(f'{number} {kind}' for kind, number in new.items())

    def _judged_rate(self, levels: DiagnosticsConfig) -> tuple[bytes, str]:
        """Return the level of the rate, and why; of the first second nothing is said."""
        elapsed_s = max(time.monotonic() - self._begun_s, 1e-6)
        expected = elapsed_s * 1e9 / self._expected_ns()
        share = self.received / expected
        if self._is_new or not self.is_timed or not share < levels.rate.warning:
            return DiagnosticStatus.OK, ''
        if expected - self.received < _SLACK:
            return DiagnosticStatus.OK, ''
        is_error = share < levels.rate.error
        level = DiagnosticStatus.ERROR if is_error else DiagnosticStatus.WARN
        hz = self.received / elapsed_s, expected / elapsed_s
        return level, f'{hz[0]:.1f} instead of {hz[1]:.1f} Hz'


def status(
    name: str, level: bytes, message: str, values: Mapping[str, object]
) -> DiagnosticStatus:
    """Return what is reported of a part of a node."""
    return DiagnosticStatus(
        level=level,
        name=name,
        message=message,
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )


def _texts(counts: Mapping[str, int]) -> dict[str, str]:
    return {kind: str(number) for kind, number in counts.items()}


def _ms(nanoseconds: float) -> str:
    return f'{nanoseconds / 1e6:.1f}'
