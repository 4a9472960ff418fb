"""A run of a trajectory database, as known now or at an earlier time."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, func, select

from mctrack_ros.recording.closing import Closing
from mctrack_ros.store.boxes import FAR, Box, find_chunks
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.identities import Identities, load_identities
from mctrack_ros.store.rows import SPAN_NS, Stored, TrackRows, load_rows, load_stamps
from mctrack_ros.store.runs import find_run
from mctrack_ros.store.schema import CAMERAS, DESCRIPTIONS, JOURNAL, RUN_CAMERAS, TICKS
from mctrack_ros.zones.shapes import Zones

ALWAYS = (-FAR, FAR)
"""All times, s."""
Between = tuple[float, float]
"""From when until before when, since the run's first tick, s."""
Moment = float | datetime
"""Seconds since a run's first tick, or a date."""
_LATEST_NS = 2**63 - 1  # what a column of 64 bits holds


@dataclass(frozen=True, slots=True)
class View:
    """
    Which identities a query sees.

    Attributes
    ----------
    as_of_s : float, optional
        What was known then, since the run's first tick, s, and no rows after it; by default all.
    corrected : bool
        Whether corrections of identities apply backwards; else ids are those of the time.

    """

    as_of_s: float | None = None
    corrected: bool = True


class Run(Closing):
    """
    A run that is asked. Times are in seconds since its first tick.

    Parameters
    ----------
    database : Database, str or Path
        Where it is; a place is opened, and closed with the run.
    name : str
        It need not be named if there is only one.
    view : View
        Which identities are seen.

    Attributes
    ----------
    name, site, frame_id : str
        Of the run, its site, and the frame of its positions.
    cameras : tuple of str
        In the order of the bits of ``cameras``.
    began_ns : int
        Stamp of its first tick, ns.

    Raises
    ------
    StoreError
        If there is no such run, or it has no tracks.

    """

    def __init__(
        self, database: Database | str | Path, name: str = '', view: View | None = None
    ) -> None:
        self._owns = not isinstance(database, Database)
        self.database = database if isinstance(database, Database) else Database(database)
        self.view = view or View()
        try:
            with self.database.connected() as connection:
                found = find_run(connection, name)
                cameras = select(CAMERAS.c.name).join(RUN_CAMERAS).order_by(RUN_CAMERAS.c.bit)
                named = cameras.where(RUN_CAMERAS.c.run_id == found.run_id)
                self.cameras = tuple(connection.execute(named).scalars())
            if found.began_ns is None:
                raise StoreError(f'run {found.name} has no tracks yet')
        except BaseException:
            self.close()
            raise
        self.name, self.site, self.frame_id = found.name, found.site, found.frame_id
        self.began_ns: int = found.began_ns
        self.stored = Stored(found.run_id, found.began_ns)

    def close(self) -> None:
        """Close the database, if the run opened it."""
        if self._owns:
            self.database.close()

    def since(self, moment: Moment) -> float:
        """Return the time of a moment, s; a date without a time zone is refused."""
        if not isinstance(moment, datetime):
            return moment
        began = datetime.fromtimestamp(self.began_ns // 10**9, UTC)
        return (moment - began).total_seconds() - self.began_ns % 10**9 / 1e9

    def ns(self, seconds: float) -> int:
        """Return the stamp of a time, ns."""
        far = self.began_ns + round(seconds * 1e9)
        return min(max(far, 0), _LATEST_NS)

    def seconds(self, stamp_ns: int) -> float:
        """Return the time of a stamp, s."""
        return (int(stamp_ns) - self.began_ns) / 1e9

    def between_ns(self, between: Between) -> tuple[int, int]:
        """Return stamps from when until before when, ns, no later than what is seen."""
        first, last = map(self.ns, between)
        if self.view.as_of_s is not None:
            last = min(last, self.ns(self.view.as_of_s) + 1)
        return first, last

    def length_s(self) -> float:
        """Return the time from the first tick until after the last one that is stored, s."""
        with self.database.connected() as connection:
            asked = (
                select(func.max(table.c.span)).where(table.c.run_id == self.stored.run)
                for table in (TICKS, JOURNAL)
            )
            last = max(connection.execute(each).scalar() or 0 for each in asked)
        return (last + 1) * SPAN_NS / 1e9

    def stamps(self, between: Between = ALWAYS) -> NDArray[np.int64]:
        """Return the stamps of all ticks, ns, (m,), ascending."""
        with self.database.connected() as connection:
            return load_stamps(connection, self.stored, self.between_ns(between))

    def description(self) -> dict[str, Any]:
        """Return what `/site` said of the run; empty: nothing."""
        asked = select(DESCRIPTIONS.c.text).where(DESCRIPTIONS.c.run_id == self.stored.run)
        with self.database.connected() as connection:
            text = connection.execute(asked.order_by(DESCRIPTIONS.c.number)).scalar()
        try:
            said = json.loads(text or '{}')
        except ValueError as error:
            raise StoreError(f'run {self.name}: what /site said is no JSON: {error}') from error
        return said if isinstance(said, dict) else {}

    def origin(self) -> tuple[float, float]:
        """Return the origin of positions in the coordinates of the site's files, m."""
        x, y = self.description().get('origin') or (0.0, 0.0)
        return float(x), float(y)

    def zones(self) -> Zones:
        """Return the zones and lines of the site, as `/site` describes them."""
        try:
            return Zones.from_description(self.description().get('zones', []))
        except (StoreError, ValueError, TypeError, KeyError, AttributeError):
            return Zones()  # another program's description

    def identities(self, connection: Connection) -> Identities:
        """Return who is who."""
        if not self.view.corrected:
            return Identities([])
        as_of_s = self.view.as_of_s
        return load_identities(
            connection, self.stored, None if as_of_s is None else self.ns(as_of_s)
        )

    def box(self, between: Between, bounds: tuple[float, float, float, float]) -> Box:
        """Return a box of times and of left, low, right and high bounds, m."""
        left, low, right, high = bounds
        return Box(self.stored.run, *between, left, right, low, high)

    def rows(
        self,
        between: Between = ALWAYS,
        *,
        tracks: Collection[int] | None = None,
        boxes: Sequence[Box] | None = None,
        whole: bool = False,
    ) -> TrackRows:
        """
        Return the rows of confirmed, coasting and grouped tracks, one for each life and stamp.

        Parameters
        ----------
        between : (float, float)
            From when until before when, s.
        tracks : collection of int, optional
            Only of these lives.
        boxes : sequence of Box, optional
            Only chunks that may reach into one of these.
        whole : bool
            Whether all columns are read, or places alone.

        """
        with self.database.connected() as connection:
            identities = self.identities(connection)
            names, chunks = None, None
            if tracks is not None:
                names = set().union(*(identities.names(track) for track in tracks))
            if boxes is not None:
                chunks = find_chunks(connection, boxes)
            rows = load_rows(
                connection,
                self.stored,
                self.between_ns(between),
                tracks=names,
                chunks=chunks,
                whole=whole,
            ).reported()
        rows = replace(rows, life=identities.lives(rows.track_id, rows.stamp_ns))
        if tracks is not None:
            rows = rows.select(np.isin(rows.life, list(tracks)))
        return _one_each(rows)


def _one_each(rows: TrackRows) -> TrackRows:
    """Keep one row of each life and stamp: where there are two, that of the name which stays."""
    order = np.lexsort([rows.life != rows.track_id, rows.life, rows.stamp_ns])
    rows = rows.select(order)
    again = (np.diff(rows.life) == 0) & (np.diff(rows.stamp_ns) == 0)
    return rows.select(np.concatenate([[True], ~again])) if again.any() else rows
