"""Time in a bag against the clocks of now."""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

SECOND_NS = 1_000_000_000

_STALL_S, _PATIENCE_S = 1.0, 10.0
"""A burst that does not go on for so long is over, and so is one that takes so long."""
_STAMP_OFFSET = 4
"""A header's stamp follows the four bytes that open every serialised message."""


@dataclass(frozen=True, slots=True)
class Pace:
    """
    Time in the bag against the steady clock.

    Attributes
    ----------
    first_ns : int
        Log time of the first message.
    rate : float
        Speed; 1: as recorded.
    began_ns : int
        Steady time at which the first message is due.
    shift_ns : int
        What is added to the stamps.

    """

    first_ns: int
    rate: float
    began_ns: int
    shift_ns: int

    def due_ns(self, time_ns: int) -> int:
        """Return the steady time at which a message is due."""
        return self.began_ns + round((time_ns - self.first_ns) / self.rate)

    def bag_ns(self, steady_ns: int) -> int:
        """Return the time in the bag at a steady time."""
        return self.first_ns + round((steady_ns - self.began_ns) * self.rate)


def shifted(data: bytes, shift_ns: int) -> bytes:
    """Return a serialised message with the stamp of its header moved."""
    order = '<' if data[1] & 1 else '>'
    stamp = struct.Struct(order + 'iI')
    seconds, nanoseconds = stamp.unpack_from(data, _STAMP_OFFSET)
    moved = divmod(seconds * SECOND_NS + nanoseconds + shift_ns, SECOND_NS)
    end = _STAMP_OFFSET + stamp.size
    return data[:_STAMP_OFFSET] + stamp.pack(*moved) + data[end:]


class Due(Enum):
    """Why waiting for a message ended."""

    NOW = 'it is due'
    JUMP = 'another place is next'
    END = 'playing ends'


class Transport:
    """
    Pace, pause, steps and jumps of a player, set from any thread.

    Parameters
    ----------
    rate : float
        Speed; 1: as recorded.
    is_paused : bool
        Whether it begins paused.

    Attributes
    ----------
    is_paused : bool
        Whether messages wait for a step.
    rate : float
        Speed.

    """

    def __init__(self, rate: float, is_paused: bool) -> None:
        self.rate, self.is_paused = rate, is_paused
        self._changed = threading.Condition()
        self._pace: Pace | None = None
        self._at_ns = 0
        self._steps = self._stepped = 0
        self._target_ns: int | None = None
        self._has_ended = False

    @property
    def at_ns(self) -> int:
        """Where it is in the bag, ns."""
        if self._pace is None or self.is_paused:
            return self._at_ns
        return self._pace.bag_ns(time.monotonic_ns())

    @property
    def next_ns(self) -> int:
        """Where it is in the bag, or will be after a jump that is asked for, ns."""
        with self._changed:
            return self.at_ns if self._target_ns is None else self._target_ns

    def restart(self) -> None:
        """Be as it was before it ended, to play from the beginning."""
        with self._changed:
            self._pace, self._target_ns, self._at_ns = None, None, 0
            self._steps, self._has_ended = 0, False

    def begin(self, pace: Pace) -> None:
        """Let the first message of a passage be due as a pace says."""
        with self._changed:
            self._pace, self._at_ns = pace, pace.first_ns

    def pause(self, is_paused: bool) -> None:
        """Stop, or go on."""
        with self._changed:
            if is_paused != self.is_paused:
                self._at_ns = self.at_ns
                self.is_paused, self._steps = is_paused, 0
                self._go_on_from(self._at_ns)

    def set_rate(self, rate: float) -> None:
        """Change the speed from now on."""
        with self._changed:
            at_ns, self.rate = self.at_ns, rate
            self._go_on_from(at_ns)

    def step(self, count: int) -> None:
        """Let so many messages go although it is paused."""
        with self._changed:
            self._steps += count if self.is_paused else 0
            self._changed.notify_all()

    def burst(self, count: int) -> int:
        """
        Let so many messages go although it is paused; return how many went.

        Fewer go where playing goes on or ends meanwhile, or where they do not go within 10 s; not
        paused: none.

        """
        with self._changed:
            first, end = self._stepped, time.monotonic() + _PATIENCE_S
            self._steps += count if self.is_paused else 0
            self._changed.notify_all()
            while self._steps and not self._has_ended and time.monotonic() < end:
                if not self._goes_on():
                    break
            self._steps = 0
            return self._stepped - first

    def _goes_on(self) -> bool:
        """Wait until a step is done, or all are off; tell whether that happened."""
        before = self._stepped
        return self._changed.wait_for(
            lambda: self._stepped > before or not self._steps or self._has_ended, _STALL_S
        )

    def jump(self, time_ns: int) -> None:
        """Go on at another place, by log time, ns."""
        with self._changed:
            self._target_ns = time_ns
            self._changed.notify_all()

    def taken_jump(self) -> int | None:
        """Return where it was to jump to, once."""
        with self._changed:
            target_ns, self._target_ns = self._target_ns, None
            if target_ns is not None:
                self._at_ns = target_ns
                self._go_on_from(target_ns)
            return target_ns

    def end(self) -> None:
        """Let nothing wait any longer."""
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()

    def wait(self, time_ns: int, step_ns: int, tell: Callable[[int], None]) -> Due:
        """
        Sleep until a message is due.

        Parameters
        ----------
        time_ns : int
            Its log time.
        step_ns : int
            Longest sleep without telling where it is.
        tell : callable
            Takes the time in the bag, ns, meanwhile.

        """
        while True:
            with self._changed:
                assert self._pace is not None
                if self._has_ended:
                    return Due.END
                if self._target_ns is not None:
                    return Due.JUMP
                if self.is_paused and self._steps:
                    self._steps -= 1
                    self._stepped += 1
                    self._changed.notify_all()
                    self._at_ns = time_ns
                    return Due.NOW
                wait_ns = self._pace.due_ns(time_ns) - time.monotonic_ns()
                if wait_ns <= 0 and not self.is_paused:
                    return Due.NOW
                self._changed.wait((step_ns if self.is_paused else min(wait_ns, step_ns)) * 1e-9)
                at_ns = min(self.at_ns, time_ns)
            tell(at_ns)

    def behind_ns(self, time_ns: int) -> int:
        """Return how long ago a message was due, ns; paused: 0."""
        assert self._pace is not None
        return 0 if self.is_paused else time.monotonic_ns() - self._pace.due_ns(time_ns)

    def _go_on_from(self, at_ns: int) -> None:
        """Let time run on from there, at the present speed."""
        if self._pace is not None:
            shift_ns = self._pace.shift_ns
            self._pace = Pace(at_ns, self.rate, time.monotonic_ns(), shift_ns)
        self._changed.notify_all()
