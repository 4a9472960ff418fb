"""Which runs a database has."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import func, select

from mctrack_ros.store.database import Database
from mctrack_ros.store.queries.results import RunSummary
from mctrack_ros.store.schema import RUNS, SITES, TRACKS


def runs(database: Database) -> list[RunSummary]:
    """Return the runs of a database, in the order of time; the open span does not count yet."""
    asked = (
        select(
            RUNS,
            SITES.c.name.label('site'),
            func.max(TRACKS.c.ended_ns).label('last_ns'),
        )
        .join(SITES, SITES.c.site_id == RUNS.c.site_id)
        .outerjoin(TRACKS, TRACKS.c.run_id == RUNS.c.run_id)
        .group_by(*RUNS.c, SITES.c.name)
    )
    with database.connected() as connection:
        found = connection.execute(asked).all()
    return [
        RunSummary(
            row.name,
            row.site,
            None if row.began_ns is None else _date(row.began_ns),
            ((row.ended_ns or row.last_ns or row.began_ns or 0) - (row.began_ns or 0)) / 1e9,
            row.ended_ns is not None,
        )
        for row in sorted(found, key=lambda each: (each.began_ns or 0, each.run_id))
    ]


def _date(stamp_ns: int) -> str:
    return datetime.fromtimestamp(stamp_ns // 10**9, UTC).isoformat()
