"""Whether the cameras' clocks agree, on `/diagnostics`."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Event
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.camera_clocks import CameraClocks, Jump
from mctrack_ros.fusion.clock_offsets.clock_offsets import ClockOffset, ClockOffsets, Snapshot
from mctrack_ros.fusion.clock_offsets.config import ClocksConfig
from mctrack_ros.interfaces import RowsTick, Tracks

ESTIMATED_EVERY = 6
"""Blocks of the estimate between two of its answers, at least."""
SHARE = 0.1
"""Of a core that estimates take on an average: with many cameras one takes seconds."""


@dataclass(frozen=True, slots=True)
class ClockAgreement:
    """
    How one camera's clock agrees with the others'.

    Attributes
    ----------
    batcher : Batcher
        Of all cameras; its clocks change with every message.
    camera : str
        The camera's name.

    """

    batcher: Batcher[Any]
    camera: str

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: a clock that is off is a warning, one left out an error."""
        clocks = self.batcher.clocks
        offset_s, added_s = clocks.offset_s(self.camera), added(self.batcher, self.camera)
        level, message = DiagnosticStatus.OK, 'its clock agrees with those of the other cameras'
        if self.camera in self.batcher.ahead_ns:
            message = f'its stamps are known to be {-added_s:.3f} s ahead: this is removed'
        elif clocks.is_behind(self.camera):
            level = DiagnosticStatus.WARN
            message = clock_message(offset_s) + ': it is slow, or its clock is behind'
        elif added_s:
            level, message = DiagnosticStatus.WARN, clock_message(offset_s) + ': this is removed'
        if clocks.is_left_out(self.camera):
            level = DiagnosticStatus.ERROR
            message = clock_message(offset_s) + ': the camera is left out until that is mended'
        values = {'offset [s]': f'{offset_s:.3f}', 'added to its stamps [s]': f'{added_s:.3f}'}
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )


@dataclass(slots=True)
class ClockJumps:
    """
    Whether the clocks of all cameras have jumped at once, and how they differ.

    Attributes
    ----------
    clocks : CameraClocks
        Of all cameras; it changes with every message.
    motion : MotionClocks, optional
        How they differ by what moves.
    reported : Jump or None
        The last that was reported.

    """

    clocks: CameraClocks
    motion: MotionClocks | None = None
    reported: Jump | None = None

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: a jump since the last report is a warning."""
        jump, level = self.clocks.jump, DiagnosticStatus.OK
        if jump is not self.reported:
            self.reported, level = jump, DiagnosticStatus.WARN
        message = f'{jump}' if jump else "all cameras' clocks go on evenly"
        own = DiagnosticStatus(level=level, name=name, message=message)
        if self.motion is not None:
            measured = self.motion.report(name)
            own.level = max(own.level, measured.level)
            own.message += '; ' + measured.message
            own.values = measured.values
        return own


class _EndedError(Exception):
    """The node ends: nobody waits for the estimate."""


@dataclass(slots=True)
class MotionClocks:
    """
    How the clocks differ by who moves in several views; corrects them if it may.

    Attributes
    ----------
    config : ClocksConfig
        What is too much, and whether it is corrected.
    batcher : Batcher
        Which adds to the stamps.
    offsets : ClockOffsets
        The estimate, of the stamps as they come.
    found : sequence of ClockOffset
        What was estimated last, in a thread of its own: it takes a second at first, with many
        cameras more.

    """

    config: ClocksConfig
    batcher: Batcher[Any]
    offsets: ClockOffsets
    found: Sequence[ClockOffset] = ()
    blocks: int = 0
    next_s: float = 0.0
    thread: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))
    asked: Future[tuple[ClockOffset, ...]] | None = None
    ended: Event = field(default_factory=Event)

    def add(self, tick: RowsTick[Any], tracks: Tracks) -> None:
        """Take a tick and its tracks; now and then estimate, and correct if that is wanted."""
        self.blocks += self.offsets.add(tick, tracks)
        is_due = self.blocks >= ESTIMATED_EVERY and time.monotonic() >= self.next_s
        if self.asked is None and is_due:
            self.blocks = 0
            self.asked = self.thread.submit(self._estimated, self.offsets.snapshot())
        elif self.asked is not None and self.asked.done():
            self.found, self.asked = self.asked.result(), None
            self._correct()

    def close(self) -> None:
        """End the thread, and what it estimates."""
        self.ended.set()
        self.thread.shutdown(cancel_futures=True)

    def _estimated(self, snapshot: Snapshot) -> tuple[ClockOffset, ...]:
        began_s = time.thread_time()
        found = self.offsets.estimate(snapshot, self._check)
        self.next_s = time.monotonic() + (time.thread_time() - began_s) / SHARE
        return found

    def _check(self) -> None:
        if self.ended.is_set():
            raise _EndedError

    def _correct(self) -> None:
        for one in filter(self._is_off, self.found if self.config.correct else ()):
            right_s = self._ahead_s(one.reference) + one.offset_s
            self.batcher.ahead_ns[one.camera] = round(right_s * 1e3) * 1_000_000

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: a clock that is surely off, after what is corrected, is a warning."""
        off = [one for one in self.found if self._is_off(one)]
        known = [one for one in self.found if one.is_known]
        message = 'not enough motion in common views yet'
        if off:
            message = ', '.join(
                f'{one.camera} is {abs(self._left_s(one)):.3f} s '
                f'{"ahead of" if self._left_s(one) > 0 else "behind"} {one.reference}'
                for one in off
            )
            message += ' by what moves in both views: set clock_offset, or the clocks'
        elif known:
            message = 'the clocks agree by what moves in several views'
        values: dict[str, str] = {}
        for one in known:
            values |= {
                f'{one.camera} offset [s]': f'{one.offset_s:.4f}',
                f'{one.camera} standard deviation [s]': f'{one.deviation_s:.4f}',
                f'{one.camera} reference': one.reference,
            }
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if off else DiagnosticStatus.OK,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )

    def _is_off(self, one: ClockOffset) -> bool:
        """Tell whether a clock is surely off by more than the limit."""
        return one.is_known and abs(self._left_s(one)) > max(self.config.limit, one.half_s)

    def _left_s(self, one: ClockOffset) -> float:
        """Return by how much a camera's corrected stamps are ahead of its reference's, s."""
        taken_s = self._ahead_s(one.camera) - self._ahead_s(one.reference)
        return one.offset_s - taken_s

    def _ahead_s(self, camera: str) -> float:
        return -added(self.batcher, camera)


def ahead_from(text: str, cameras: Sequence[str]) -> dict[str, int]:
    """
    Read by how much cameras' clocks are ahead, ``camera=seconds,...``: whole ms, in ns.

    Raises
    ------
    ConfigError
        If one is not that, or no camera.

    """
    ahead_ns = {}
    for part in filter(None, text.split(',')):
        camera, _, offset = part.strip().partition('=')
        try:
            ahead_ns[camera] = round(float(offset) * 1e3) * 1_000_000
        except ValueError as error:
            raise ConfigError(
                f'clock_offsets has {part!r}, expected camera=seconds, for example cam1=0.05'
            ) from error
        if camera not in cameras:
            raise ConfigError(f'clock_offsets names {camera}, which is none of the cameras')
    return ahead_ns


def added(batcher: Batcher[Any], camera: str) -> float:
    """Return what is added to a camera's stamps, s."""
    known_ns = batcher.ahead_ns.get(camera)
    return batcher.clocks.added_s(camera) if known_ns is None else -known_ns * 1e-9


def clock_message(offset_s: float) -> str:
    """Say how a camera's stamps differ from the others'."""
    word = 'ahead of' if offset_s > 0 else 'behind'
    return f"its stamps lie {abs(offset_s):.3f} s {word} the other cameras'"
