"""Whether the cameras' clocks agree, judged by when their messages arrive."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import median_low
from typing import NamedTuple

from mctrack_ros.fusion.config import BatchingConfig

SECOND_NS = 1_000_000_000
KEPT = 9
"""A camera's clock is judged by so many of its last messages: up to four of them may be wrong."""

JUMPED = 3
"""Number of messages in a row, out of line with those before, that show a jump of the clock."""

MOST_TOLERATED_NS = 50_000_000
"""What a longer wait would absorb is removed all the same: in it people walk 7 cm, ns."""

BEHIND_NS = SECOND_NS
"""
Whatever is farther behind is left out, ns. A delay of less may pass, unless the stamps went back:
no delay does that.
"""


class Verdict(NamedTuple):
    """
    What is made of one message.

    Attributes
    ----------
    added_ns : int
        What its stamp lacks, ns; negative for a clock that is ahead.
    lag_ns : int
        How long after its stamp it has come, once that is added, ns.
    is_used : bool
        Whether its stamp can be believed, once that is added.
    reference_ns : int
        The lag that cameras are held against, ns.

    """

    added_ns: int
    lag_ns: int
    is_used: bool
    reference_ns: int


class Jump(NamedTuple):
    """
    A step of clocks: of one camera's, or of all cameras' at once.

    Attributes
    ----------
    begin_ns, end_ns : int
        Arrival of the first message after it, and of the one that proves it, ns.
    by_ns : int
        By how much the stamps went on beyond the time that passed, ns; negative: they went back.

    """

    begin_ns: int
    end_ns: int
    by_ns: int

    def __str__(self) -> str:
        """Say it of all cameras."""
        way = 'ahead' if self.by_ns > 0 else 'back'
        return (
            f"all cameras' stamps jumped {way} by {abs(self.by_ns) / SECOND_NS:.3f} s at "
            f'{self.begin_ns / SECOND_NS:.3f} s'
        )


@dataclass
class _Clock:
    """One camera's: how long after their stamps its messages arrive."""

    lags_ns: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT))
    strange_ns: list[int] = field(default_factory=list)
    strange_since_ns: int = 0
    jump: Jump | None = None
    heard_ns: int = 0
    stamp_ns: int = 0
    lag_ns: int = 0
    added_ns: int = 0
    is_left_out: bool = False
    offset_ns: int = 0

    def hear(self, stamp_ns: int, arrival_ns: int, limit_ns: int) -> bool:
        """Take a message; tell whether its stamp is in line with those before."""
        lag_ns, self.heard_ns = arrival_ns - stamp_ns, arrival_ns
        known = self.lags_ns or (lag_ns,)
        steps_back = stamp_ns < self.stamp_ns and lag_ns > max(known) + limit_ns
        if not steps_back and lag_ns >= min(known) - limit_ns:
            self.lags_ns.append(lag_ns)
        else:
            if not self.strange_ns:
                self.strange_since_ns = arrival_ns
            self.strange_ns.append(lag_ns)
            if len(self.strange_ns) < JUMPED:
                return False
            by_ns = median_low(self.lags_ns) - median_low(self.strange_ns)
            self.jump = Jump(self.strange_since_ns, arrival_ns, by_ns)
            self.lags_ns.clear()
            self.lags_ns.extend(self.strange_ns)
        self.strange_ns.clear()
        self.stamp_ns = stamp_ns
        self.lag_ns = median_low(self.lags_ns)
        return True


class CameraClocks:
    """
    Compares the cameras' clocks; is given all times and reads no clock.

    A message's lag is the time from its stamp to its arrival: what the clock is behind, and how
    long the message took. The reference is the lag in the middle of the most cameras that agree
    within `time_sync_limit`; of equally many, those whose stamps lie nearer to the arrival. What
    a camera differs from it is added to its stamps, where waiting for it would not do. A camera
    that differs by more than the limit is left out if it is ahead, or if its stamps went back;
    any other that is behind may only be slow, and is left out from a second on. So is a single
    stamp that is farther from those before it than the limit.

    Parameters
    ----------
    config : BatchingConfig
        ``time_sync_limit`` and what the batcher waits for.
    cameras : sequence of str
        Their names.

    Attributes
    ----------
    jump : Jump or None
        The last one of all live cameras at once.

    """

    def __init__(self, config: BatchingConfig, cameras: Sequence[str]) -> None:
        self._stated = config
        self.set_rate(1.0)
        self._patience_ns = round(config.patience * SECOND_NS)
        self._clocks = {camera: _Clock() for camera in cameras}
        self._now_ns = 0
        self._unsure_since_ns: int | None = None
        self.jump: Jump | None = None

    def set_rate(self, rate: float) -> None:
        """Let time go so many times too fast: delays seem longer by that."""
        config = self._stated
        self._limit_ns = round(config.time_sync_limit * SECOND_NS * rate)
        wait_ns = config.max_wait * config.period * SECOND_NS
        self._tolerated_ns = round(min(wait_ns, MOST_TOLERATED_NS) * rate)

    def judge(self, camera: str, stamp_ns: int, arrival_ns: int) -> Verdict:
        """
        Judge a message.

        Parameters
        ----------
        camera : str
            Who sent it.
        stamp_ns : int
            Its stamp, ns.
        arrival_ns : int
            When it arrived, or was recorded, on a clock like that of the stamps, ns.

        """
        if not self._limit_ns:
            return Verdict(0, 0, True, 0)
        clock, lag_ns = self._clocks[camera], arrival_ns - stamp_ns
        self._now_ns = arrival_ns
        is_in_line = clock.hear(stamp_ns, arrival_ns, self._limit_ns)
        if self.has_jumped(camera):
            self._compare_jumps()
        self._note_doubts()
        reference_ns = self._reference_ns()
        clock.offset_ns = reference_ns - clock.lag_ns
        clock.is_left_out = self._is_beyond(clock, reference_ns)
        if abs(clock.offset_ns) <= self._limit_ns:
            self._settle(clock)
        agrees = abs(lag_ns - reference_ns) <= self._limit_ns
        is_used = agrees or (is_in_line and not clock.is_left_out)
        return Verdict(clock.added_ns, lag_ns - clock.added_ns, is_used, reference_ns)

    def offset_s(self, camera: str) -> float:
        """Return by how much a camera's clock is ahead of the reference, s."""
        return self._clocks[camera].offset_ns / SECOND_NS

    def added_s(self, camera: str) -> float:
        """Return what is added to a camera's stamps, s."""
        return self._clocks[camera].added_ns / SECOND_NS

    def is_left_out(self, camera: str) -> bool:
        """Tell whether a camera's stamps cannot be used, and no other's have followed."""
        return self._clocks[camera].is_left_out and not self.is_settling

    def is_behind(self, camera: str) -> bool:
        """Tell whether a camera's messages come later than the others' by more than the limit."""
        return self._clocks[camera].offset_ns < -self._limit_ns

    def disagrees(self, camera: str, reference_ns: int) -> bool:
        """Tell whether a camera that was heard is left out where lags are held against another."""
        return self._is_beyond(self._clocks[camera], reference_ns)

    def has_jumped(self, camera: str) -> bool:
        """Tell whether the last message proves that a camera's clock has jumped."""
        jump = self._clocks[camera].jump
        return jump is not None and jump.end_ns == self._now_ns

    @property
    def is_settling(self) -> bool:
        """Whether a clock has jumped, or may have, so shortly ago that others may follow."""
        since_ns = self._unsure_since_ns
        return since_ns is not None and self._now_ns - since_ns <= 2 * self._patience_ns

    def _is_beyond(self, clock: _Clock, reference_ns: int) -> bool:
        went_back = clock.jump is not None and clock.jump.by_ns < 0
        behind_ns = self._limit_ns if went_back else BEHIND_NS
        return not -behind_ns <= reference_ns - clock.lag_ns <= self._limit_ns

    def _note_doubts(self) -> None:
        """Note since when a live camera has strange stamps, or a clock that has just jumped."""
        is_unsure = any(
            clock.strange_ns
            or (clock.jump is not None and self._now_ns - clock.jump.end_ns <= self._patience_ns)
            for clock in self._clocks.values()
            if self._is_live(clock)
        )
        if not is_unsure:
            self._unsure_since_ns = None
        elif self._unsure_since_ns is None:
            self._unsure_since_ns = self._now_ns

    def _compare_jumps(self) -> None:
        """Note whether all cameras heard of late have jumped at once, and by the same."""
        live = [clock for clock in self._clocks.values() if clock.lags_ns and self._is_live(clock)]
        jumps = [clock.jump for clock in live if clock.jump is not None]
        begins_ns, by_ns = [each.begin_ns for each in jumps], [each.by_ns for each in jumps]
        if (
            len(jumps) == len(live)
            and (self.jump is None or min(begins_ns) > self.jump.end_ns)
            and max(begins_ns) - min(begins_ns) <= self._patience_ns
            and max(by_ns) - min(by_ns) <= self._limit_ns
        ):
            self.jump = Jump(min(begins_ns), self._now_ns, median_low(by_ns))

    def _is_live(self, clock: _Clock) -> bool:
        return abs(self._now_ns - clock.heard_ns) <= self._patience_ns

    def _settle(self, clock: _Clock) -> None:
        """Change what is added to a camera's stamps once it is plainly another, in whole ms."""
        is_new = len(clock.lags_ns) < KEPT
        if is_new or abs(clock.offset_ns + clock.added_ns) > self._tolerated_ns:
            is_plain = abs(clock.offset_ns) > self._tolerated_ns
            clock.added_ns = -round(clock.offset_ns / 1e6) * 1_000_000 if is_plain else 0

    def _reference_ns(self) -> int:
        """Return the lag of the cameras that agree, among those heard of late."""
        lags = sorted(
            clock.lag_ns
            for clock in self._clocks.values()
            if clock.lags_ns and self._is_live(clock)
        )
        ranges = [
            (bisect_left(lags, lag - self._limit_ns), bisect_right(lags, lag + self._limit_ns))
            for lag in lags
        ]
        most = max(last - first for first, last in ranges)
        middles = (_middle(lags[a:b]) for a, b in ranges if b - a == most)
        return min(middles, key=abs)


def _middle(lags: list[int]) -> int:
    """Return the median of sorted lags; of the two in the middle that nearer to none."""
    return min(lags[(len(lags) - 1) // 2], lags[len(lags) // 2], key=abs)
