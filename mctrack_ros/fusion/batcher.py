"""Sorts the cameras' messages into ticks; is given the time and reads no clock."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median_low
from typing import Generic, TypeVar

import numpy as np

from mctrack_ros.fusion.camera_clocks import CameraClocks
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.interfaces import RESTART_NS, CameraRows, RowsTick, Stamped, Ticks, starts_anew

R = TypeVar('R', bound=Stamped)

SECOND_NS = 1_000_000_000

INTERVALS = 5
"""Over how many of its last images a camera's interval is judged."""


@dataclass
class _Camera:
    """What is known of one camera, and what to record of it in the next tick."""

    last_stamp_ns: int | None = None
    heard_ns: int | None = None
    intervals_ns: deque[int] = field(default_factory=lambda: deque(maxlen=INTERVALS))
    interval_ns: int = 0
    late: int = 0
    dropped_rows: int = 0
    feedback_missed: int = 0
    left_out: int = 0

    def hear(self, stamp_ns: int, now_ns: int) -> None:
        self.heard_ns = now_ns
        if self.last_stamp_ns is not None and stamp_ns > self.last_stamp_ns:
            self.intervals_ns.append(stamp_ns - self.last_stamp_ns)
            self.interval_ns = median_low(self.intervals_ns)
        self.last_stamp_ns = max(stamp_ns, self.last_stamp_ns or stamp_ns)

    def has_passed(self, start_ns: int, end_ns: int) -> bool:
        """
        Tell whether no more images are to be expected from a period.

        A camera that is a second behind, or a period if that is longer, is not waited for.
        """
        last = self.last_stamp_ns
        if last is None or last >= end_ns:
            return last is not None
        if last + self.interval_ns < start_ns - max(RESTART_NS, end_ns - start_ns):
            return True
        if not self.intervals_ns:
            return last >= start_ns
        slack = self.interval_ns // 8
        return last + self.interval_ns + (slack if last >= start_ns else -slack) >= end_ns

    def expected_ns(self, start_ns: int, end_ns: int) -> int:
        """Return the stamp, ns, of the image to come in a period; 0: none is expected."""
        last, interval_ns = self.last_stamp_ns, self.interval_ns
        if last is None or not interval_ns or last >= start_ns:
            return 0
        stamp_ns = last - (last - start_ns) // interval_ns * interval_ns
        return stamp_ns if stamp_ns < end_ns else 0

    def step_back(self) -> None:
        """Take notice that the camera's clock is another one from now on."""
        self.last_stamp_ns, self.interval_ns = None, 0
        self.intervals_ns.clear()

    def take_counts(self) -> tuple[int, int, int, int]:
        counts = self.late, self.dropped_rows, self.feedback_missed, self.left_out
        self.late = self.dropped_rows = self.feedback_missed = self.left_out = 0
        return counts


@dataclass
class _Pending(Generic[R]):
    """A tick that waits: its messages, and of each the arrival and the lag, ns."""

    messages: dict[tuple[str, int], R] = field(default_factory=dict)
    added_ns: dict[tuple[str, int], int] = field(default_factory=dict)
    arrivals_ns: dict[tuple[str, int], tuple[int, int]] = field(default_factory=dict)

    def first_arrival_ns(self, reference_ns: int) -> int:
        """Return when its first message arrived; one that came early counts as usual, ns."""
        arrivals_ns = [self.arrivals_ns[key] for key in self.messages]
        return min(now_ns + max(reference_ns - lag_ns, 0) for now_ns, lag_ns in arrivals_ns)


class Batcher(Generic[R]):
    """
    Groups messages into ticks: a message belongs to the period that its own stamp falls in.

    A tick closes when no live camera is expected to add to it, or `max_wait` after its first
    message arrived; a message that arrives earlier than usual for its stamp counts as arriving at
    the usual time. Ticks close in order; what comes for a closed one is late: dropped and
    counted. Clocks that disagree are set right or left out first (`CameraClocks`). At the start
    each camera counts as live for one `camera_timeout`. Time begins anew when the stamps of all
    live cameras have stepped back by more than a second; what one of them alone sends from then
    on is late.

    Parameters
    ----------
    config : FusionConfig
        Its `batching` is used.
    cameras : tuple of str
        Names in the site's order.
    unusable : callable
        Tells of a message how many of its rows cannot be used, which are counted as dropped;
        unless given, all can.

    Attributes
    ----------
    clocks : CameraClocks
        How the cameras' clocks agree, by when messages arrive.
    ahead_ns : dict of str to int
        By how much the clocks of cameras are known to be ahead, ns: that is taken from their
        stamps, and nothing else is added to them. In whole milliseconds.
    max_wait : float
        Longest wait for a camera after the first arrival, periods.

    Raises
    ------
    ValueError
        If a name occurs twice.

    """

    def __init__(
        self,
        config: FusionConfig,
        cameras: tuple[str, ...],
        unusable: Callable[[R], int] = lambda rows: 0,
    ) -> None:
        if len(set(cameras)) != len(cameras):
            raise ValueError(f'cameras are {cameras!r}, expected distinct names')
        settings = config.batching
        self.period_ns = round(settings.period * SECOND_NS)
        self.max_wait = settings.max_wait
        self._timeout_ns = round(settings.patience * SECOND_NS)
        self.clocks = CameraClocks(settings, cameras)
        self.ahead_ns: dict[str, int] = {}
        self._sync_ns = round(settings.time_sync_limit * SECOND_NS)
        self._unusable = unusable
        self._reference_ns = 0
        self._cameras = {name: _Camera() for name in cameras}
        self._pending: dict[int, _Pending[R]] = {}
        self._closed_index: int | None = None
        self._closed_ns: int | None = None
        self._started_ns: int | None = None
        self._admitted_ns = 0

    def add(
        self, camera: str, rows: R, now_ns: int, arrival_ns: int | None = None
    ) -> list[RowsTick[R]]:
        """
        Take a camera's message and return the ticks that it completes.

        Parameters
        ----------
        camera : str
            Who sent it.
        rows : Rows
            The message; an empty one is a heartbeat.
        now_ns : int
            Its arrival on any clock that does not step back, ns.
        arrival_ns : int, optional
            The same on a clock like that of the stamps, ns, by which the cameras' clocks are
            judged; unless given, all stamps are right.

        Raises
        ------
        ValueError
            If the camera is not known.

        """
        if camera not in self._cameras:
            raise ValueError(f'camera is {camera!r}, expected one of {list(self._cameras)}')
        closed = self.poll(now_ns)
        known_ns = self.ahead_ns.get(camera)
        added_ns, verdict = -(known_ns or 0), None
        rows = rows.at(rows.stamp_ns + added_ns) if added_ns else rows
        if arrival_ns is not None:
            verdict = self.clocks.judge(camera, rows.stamp_ns, arrival_ns)
            if not verdict.is_used:
                self._cameras[camera].left_out += 1
                return closed
            if known_ns is None:
                added_ns = verdict.added_ns
                rows = rows.at(rows.stamp_ns + added_ns)
        if self._started_ns is None:
            self._started_ns = self._admitted_ns = now_ns
        are_others_right = verdict is not None and self._follows(verdict.reference_ns)
        if self._has_begun_anew(camera, rows.stamp_ns, now_ns, are_others_right):
            closed += self.begin_anew()
        lag_ns = None if verdict is None else verdict.lag_ns
        self._admit(camera, rows, now_ns, lag_ns, added_ns)
        return closed + self.poll(now_ns)

    def _follows(self, reference_ns: int) -> bool:
        """Follow the clock of the others; tell whether it is another one than before."""
        is_another = abs(reference_ns - self._reference_ns) > self._sync_ns
        self._reference_ns = reference_ns
        if is_another:
            self._leave_out(reference_ns)
        return is_another

    def go_on_after(self, stamp_ns: int) -> None:
        """Take what is not after the last tick of an earlier process for late."""
        self._closed_index, self._closed_ns = stamp_ns // self.period_ns, stamp_ns

    def _max_wait_ns(self) -> int:
        return round(self.max_wait * self.period_ns)

    def poll(self, now_ns: int) -> list[RowsTick[R]]:
        """Return the ticks that are due by now."""
        due = [index for index in self._pending if self._is_due(index, now_ns)]
        return self._close_up_to(max(due), now_ns) if due else []

    def deadline_ns(self) -> int | None:
        """Return when `poll` must be called at the latest; None: nothing is pending."""
        arrivals = self._first_arrivals_ns()
        return min(arrivals) + self._max_wait_ns() if arrivals else None

    def flush(self) -> list[RowsTick[R]]:
        """Close all that is pending."""
        if not self._pending:
            return []
        return self._close_up_to(max(self._pending), max(self._first_arrivals_ns()))

    def _first_arrivals_ns(self) -> list[int]:
        return [each.first_arrival_ns(self._reference_ns) for each in self._pending.values()]

    def feedback_missed(self, camera: str, count: int) -> None:
        """Record that a camera went without feedback for so many images."""
        self._cameras[camera].feedback_missed += count

    def _leave_out(self, reference_ns: int) -> None:
        """Take out of what is pending the cameras that a new reference shows to be wrong."""
        for index, pending in list(self._pending.items()):
            for camera, stamp_ns in list(pending.messages):
                if self.clocks.disagrees(camera, reference_ns):
                    del pending.messages[camera, stamp_ns]
                    self._cameras[camera].left_out += 1
            if not pending.messages:
                del self._pending[index]

    def _has_begun_anew(
        self, camera: str, stamp_ns: int, now_ns: int, are_others_right: bool
    ) -> bool:
        """
        Tell whether time begins anew: not while another live camera is ahead of that.

        It does at once when other cameras than before have turned out to be right.

        The tick that it begins with, and that may end a period later, must be a second earlier
        than all that is known.
        """
        state = self._cameras[camera]
        is_starved = now_ns - self._admitted_ns >= self._timeout_ns
        steps_back = starts_anew(stamp_ns, state.last_stamp_ns)
        if not (is_starved or steps_back or are_others_right) or stamp_ns >= self._oldest_ns():
            return False
        if is_starved or are_others_right:
            return True
        state.step_back()
        return all(
            not starts_anew(stamp_ns, other.last_stamp_ns)
            for other in self._cameras.values()
            if other is not state and self._is_live(other, now_ns)
        )

    def _oldest_ns(self) -> int:
        """Return before which stamp time would begin anew."""
        known = [stamp_ns for one in self._pending.values() for _, stamp_ns in one.messages]
        known += [] if self._closed_ns is None else [self._closed_ns]
        return max(known, default=0) - RESTART_NS - self.period_ns

    def _is_closed(self, stamp_ns: int) -> bool:
        closed = self._closed_index
        return closed is not None and stamp_ns // self.period_ns <= closed

    def begin_anew(self) -> list[RowsTick[R]]:
        """Close all that is pending; whatever comes then is not late."""
        closed = self.flush()
        self._closed_index = self._closed_ns = None
        for state in self._cameras.values():
            state.step_back()
        return closed

    def _admit(self, camera: str, rows: R, now_ns: int, lag_ns: int | None, added_ns: int) -> None:
        state, stamp_ns = self._cameras[camera], rows.stamp_ns
        index = stamp_ns // self.period_ns
        state.hear(stamp_ns, now_ns)
        known = self._pending.get(index)
        if self._is_closed(stamp_ns) or (known and (camera, stamp_ns) in known.messages):
            state.late += 1
            state.dropped_rows += len(rows)
            return
        pending = self._pending.setdefault(index, _Pending())
        if lag_ns is None:
            arrival_ns = now_ns, self._reference_ns
        else:
            arrival_ns = now_ns + self._pause_ns(stamp_ns, now_ns), lag_ns
        pending.arrivals_ns[camera, stamp_ns] = arrival_ns
        pending.messages[camera, stamp_ns] = rows
        pending.added_ns[camera, stamp_ns] = added_ns
        self._admitted_ns = now_ns
        state.dropped_rows += self._unusable(rows)

    def _pause_ns(self, stamp_ns: int, now_ns: int) -> int:
        """Return how long after an image the last one of its period is expected, ns."""
        start_ns = stamp_ns // self.period_ns * self.period_ns
        expected = (
            state.expected_ns(start_ns, start_ns + self.period_ns)
            for state in self._cameras.values()
            if self._is_live(state, now_ns)
        )
        return max(max(expected, default=0) - stamp_ns, 0)

    def _is_live(self, state: _Camera, now_ns: int) -> bool:
        heard = self._started_ns if state.heard_ns is None else state.heard_ns
        return heard is not None and now_ns - heard < self._timeout_ns

    def _is_due(self, index: int, now_ns: int) -> bool:
        first_ns = self._pending[index].first_arrival_ns(self._reference_ns)
        if now_ns >= first_ns + self._max_wait_ns():
            return True
        start_ns = index * self.period_ns
        return all(
            state.has_passed(start_ns, start_ns + self.period_ns)
            for state in self._cameras.values()
            if self._is_live(state, now_ns)
        )

    def _close_up_to(self, last: int, now_ns: int) -> list[RowsTick[R]]:
        indices = sorted(index for index in self._pending if index <= last)
        self._closed_index = last
        ticks = [self._tick(self._pending.pop(index), now_ns) for index in indices]
        self._closed_ns = ticks[-1].stamp_ns
        return ticks

    def _tick(self, pending: _Pending[R], now_ns: int) -> RowsTick[R]:
        order = sorted(pending.messages)
        messages = tuple(CameraRows(key[0], pending.messages[key]) for key in order)
        stamp_ns = max(message.rows.stamp_ns for message in messages)
        return RowsTick(
            stamp_ns, messages, self._record(stamp_ns, messages, pending.added_ns, now_ns)
        )

    def _by_added(
        self, messages: tuple[CameraRows[R], ...], added_ns: dict[tuple[str, int], int]
    ) -> tuple[list[tuple[int, int]], list[list[R]]]:
        """Return camera and what was added to its stamps, ms, every camera first; their rows."""
        names = list(self._cameras)
        alike: dict[tuple[int, int], list[R]] = {}
        for each in messages:
            added_ms = added_ns[each.camera, each.rows.stamp_ns] // 1_000_000
            alike.setdefault((names.index(each.camera), added_ms), []).append(each.rows)
        first: dict[int, tuple[int, int]] = {}
        for key in alike:
            first.setdefault(key[0], key)
        keys = [first.get(row, (row, 0)) for row in range(len(names))]
        keys += [key for key in alike if key not in keys]
        return keys, [alike.get(key, []) for key in keys]

    def _record(
        self,
        stamp_ns: int,
        messages: tuple[CameraRows[R], ...],
        added_ns: dict[tuple[str, int], int],
        now_ns: int,
    ) -> Ticks:
        """Return what was admitted; a camera's messages to whose stamps more was added follow."""
        names = list(self._cameras)
        keys, rows = self._by_added(messages, added_ns)
        live = np.array([self._is_live(state, now_ns) for state in self._cameras.values()], bool)
        counts = [state.take_counts() for state in self._cameras.values()]
        late, dropped, missed, left_out = np.array(counts, int).reshape(-1, 4).T
        admitted, more = np.array([len(each) for each in rows]), len(keys) - len(names)
        missing = np.append(live & (admitted[: len(names)] == 0), np.zeros(more, bool))
        late, dropped, missed, left_out = (
            np.append(each, np.zeros(more, int)) for each in (late, dropped, missed, left_out)
        )
        camera = [row for row, _ in keys]
        return Ticks.build(
            stamp_ns,
            camera=camera,
            admitted=admitted,
            detections=[sum(map(len, each)) for each in rows],
            late=late,
            dropped_detections=dropped,
            feedback_missed=missed,
            missing=missing,
            alive=live[camera],
            left_out=left_out,
            added_ms=[added_ms for _, added_ms in keys],
            age_us=[(stamp_ns - each[0].stamp_ns) // 1000 if each else 0 for each in rows],
        )
