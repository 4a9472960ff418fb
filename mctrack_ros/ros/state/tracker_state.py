"""The state of fusion's tracker in a file, from which the next process goes on."""

from __future__ import annotations

import time
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.fusion.trackers import FusionTracker
from mctrack_ros.replay.proof.state import StateError, TakenState, stated, take_state
from mctrack_ros.zones.engine import ZoneEngine

_KEEP_NS = 500_000_000
"""Largest age of what is kept, if nothing happens: people walk 0.7 m in that time."""
_RECENT_S = 10.0
"""Time for which the diagnostics warn of a restart."""


@dataclass(frozen=True, slots=True)
class Kept:
    """
    A state that an earlier process has left.

    Attributes
    ----------
    data : bytes
        The state, as `take_state` packs it.
    run : str
        What the run was called.
    stamp_ns : int
        Of its last tick, ns.
    zones : dict
        What was known of tracks in zones, as `ZoneEngine.memory` returns it.

    """

    data: bytes
    run: str
    stamp_ns: int
    zones: dict[str, Any]


class TrackerState:
    """
    Keep the state of a tracker, so that a node that is killed goes on with the same ids.

    A thread writes it, twice a second and after ticks in which something happened. The file is
    replaced, never changed.

    Parameters
    ----------
    path : Path or None
        The file; None: nothing is kept.
    longest_s : float
        How old a state may be with which a process goes on, by the clock of the machine, s.
    fits : mapping of str to object
        Plain values: what must be the same in the process that goes on.

    Attributes
    ----------
    blind_s : float or None
        How long nobody tracked before this process went on, s; None: it has begun anew.

    """

    def __init__(self, path: Path | None, longest_s: float, fits: Mapping[str, Any]) -> None:
        self._path = path if longest_s > 0 else None
        self._longest_s, self._fits = longest_s, dict(fits)
        self._writer = ThreadPoolExecutor(1)
        self._writing: Future[None] | None = None
        self._kept_ns, self._is_due = 0, False
        self._failure = ''
        self._went_on_s = 0.0
        self._tracks = 0
        self.blind_s: float | None = None

    def find(self) -> Kept | None:
        """Return what is kept, if it fits and is not too old."""
        if self._path is None:
            return None
        try:
            data = self._path.read_bytes()
            said = stated(data)
            age_s = time.time() - float(said['time_s'])
            if said['fits'] != self._fits or not -1.0 <= age_s <= self._longest_s:
                return None
            return Kept(data, str(said['run']), int(said['stamp_ns']), said['zones'])
        except (OSError, StateError, LookupError, TypeError, ValueError):
            return None  # there is none that can be read: a new run begins

    def went_on(self, before: Kept, stamp_ns: int, tracks: int) -> str:
        """Take notice of the first tick after a restart, and return what to say about it."""
        self.blind_s = (stamp_ns - before.stamp_ns) * 1e-9
        self._went_on_s, self._tracks = time.monotonic(), tracks
        return self._summary()

    def keep(
        self, tracker: FusionTracker, zones: ZoneEngine, run: str, stamp_ns: int, at_once: bool
    ) -> None:
        """Keep the state after a tick: now and then, or at once."""
        if self._path is None:
            return
        self._is_due |= at_once or abs(stamp_ns - self._kept_ns) >= _KEEP_NS
        if self._is_due and (self._writing is None or self._writing.done()):
            self._is_due = False
            try:
                taken = take_state(tracker)
            except StateError as error:  # of a tracker of somebody else's
                self._failure, self._path = str(error), None
                return
            said = {
                'run': run,
                'stamp_ns': stamp_ns,
                'time_s': time.time(),
                'fits': self._fits,
                'zones': zones.memory(),
            }
            self._kept_ns = stamp_ns
            self._writing = self._writer.submit(self._write, taken, said)

    def close(self, forget: bool) -> None:
        """End the thread; forget the state if the next process is not to go on with it."""
        self._writer.shutdown()
        if forget and self._path is not None:
            with suppress(OSError):
                self._path.unlink()

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: tracking that was interrupted a short while ago is a warning."""
        is_recent = self.blind_s is not None and time.monotonic() - self._went_on_s < _RECENT_S
        message = 'tracks since the run began' if self.blind_s is None else self._summary()
        if self._failure:
            message = f'a restart would lose all ids: {self._failure}'
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if is_recent or self._failure else DiagnosticStatus.OK,
            name=name,
            message=message,
            values=[
                KeyValue(key='blind [s]', value=f'{self.blind_s or 0.0:.3f}'),
                KeyValue(key='tracks that went on', value=str(self._tracks)),
            ],
        )

    def _summary(self) -> str:
        return f'was blind for {self.blind_s:.2f} s: {self._tracks} tracks went on with their ids'

    def _write(self, taken: TakenState, said: dict[str, Any]) -> None:
        assert self._path is not None
        fresh = self._path.with_name(self._path.name + '.new')
        try:
            fresh.write_bytes(taken.packed(said))
            fresh.replace(self._path)
        except OSError as error:
            self._failure = f'{self._path}: {error.strerror}'
        else:
            self._failure = ''
