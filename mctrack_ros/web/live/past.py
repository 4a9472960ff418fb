"""The past, from a trajectory database; a run may still be being written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.store import Database, Run, events
from mctrack_ros.store.rows import TrackRows
from mctrack_ros.store.runs import newest_run
from mctrack_ros.web.live.event_lines import stored_line
from mctrack_ros.web.live.frames import past_message

BEFORE_S, AFTER_S = 8.0, 8.0
"""What is sent around an instant that is asked for: its trails, and what is played next."""
EVENTS_BEFORE_S = 60.0
MOST_ROWS = 20_000
MOST_EVENTS = 200
_NEAR_S = 5.0


@dataclass(frozen=True, slots=True)
class Extent:
    """A run: its name, and from when until when it goes, s since 1970."""

    run: str
    began_s: float
    ended_s: float


@dataclass(frozen=True, slots=True)
class Block:
    """What is known around an instant: `past_message` and events, the last ones before it."""

    message: bytes
    events: list[dict[str, Any]]


class Past:
    """
    A run of a trajectory database, by times since 1970.

    Parameters
    ----------
    place : str or Path
        The database.
    run : str
        Name of the run; empty: the newest.

    Raises
    ------
    StoreError
        By every method, if the database or the run is not there (yet).

    """

    def __init__(self, place: str | Path, run: str = '') -> None:
        self._place, self._named = place, run
        self._database: Database | None = None
        self._run: Run | None = None

    def close(self) -> None:
        """Close the database."""
        if self._database is not None:
            self._database.close()

    def extent(self) -> Extent:
        """Look for the run, and say how far it goes by now."""
        if self._database is None:
            self._database = Database(self._place)
        name = self._named
        if not name:
            with self._database.connected() as connection:
                name = newest_run(connection)
        if self._run is None or self._run.name != name:
            self._run = Run(self._database, name)
        began_s = self._run.began_ns / 1e9
        return Extent(name, began_s, began_s + self._run.length_s())

    def block(self, at_s: float) -> Block:
        """Return what is known around an instant."""
        run = self._open()
        at = at_s - run.began_ns / 1e9
        between = (at - BEFORE_S, at + AFTER_S)
        rows = _thinned(run.rows(between, whole=True))
        first_ns, last_ns = run.ns(between[0]), run.ns(between[1])
        found = events(run, between=(at - EVENTS_BEFORE_S, between[1]))
        lines = [stored_line(each) for each in found[-MOST_EVENTS:]]
        return Block(past_message(rows, (first_ns, last_ns)), lines)

    def last_seen(self, track: int, before_s: float) -> float | None:
        """Return when a track was seen last before an instant; None: never."""
        run = self._open()
        until = before_s - run.began_ns / 1e9
        # most are asked for soon after they were there: the whole run is read only for others
        for since in (until - _NEAR_S, 0.0):
            rows = run.rows((since, until), tracks=[track])
            if len(rows):
                return float(rows.stamp_ns[-1]) / 1e9
        return None

    def _open(self) -> Run:
        if self._run is None:
            self.extent()
        assert self._run is not None
        return self._run


def _thinned(rows: TrackRows) -> TrackRows:
    """Keep so many instants that no more than `MOST_ROWS` rows are left."""
    step = -(-len(rows) // MOST_ROWS)
    if step <= 1:
        return rows
    _, instant = np.unique(rows.stamp_ns, return_inverse=True)
    return rows.select(np.flatnonzero(instant % step == 0))
