"""Runs, sites, cameras and their videos."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from itertools import chain, count
from typing import Any

from sqlalchemy import Connection, Row, Table, insert, select

from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.schema import (
    CAMERAS,
    DESCRIPTIONS,
    PROGRESS,
    RUN_CAMERAS,
    RUNS,
    SITES,
    upsert,
)


@dataclass(frozen=True, slots=True)
class NewRun:
    """
    A run that is written.

    Attributes
    ----------
    name : str
        Unique in the database.
    site : str
        Name of the site.
    cameras : tuple of str
        In the order of the bits of ``cameras``.
    frame_id : str
        Frame of the positions.

    """

    name: str
    site: str = 'site'
    cameras: tuple[str, ...] = ()
    frame_id: str = 'map'


def begin_run(connection: Connection, run: NewRun, *, resume: bool) -> tuple[int, int | None]:
    """
    Return the number of a run, and the stamp of its first tick if it has one, ns.

    Raises
    ------
    StoreError
        If it is there already and not to be continued, or finished.

    """
    asked = select(RUNS.c.run_id, RUNS.c.began_ns, RUNS.c.ended_ns)
    found = connection.execute(asked.where(RUNS.c.name == run.name)).one_or_none()
    if found is not None:
        if not resume:
            raise StoreError(f'run {run.name} is in the database already')
        if found.ended_ns is not None:
            raise StoreError(f'run {run.name} is finished: write what follows as another run')
        return found.run_id, found.began_ns
    site = number_of(connection, SITES, {'name': run.site})
    values = {'site_id': site, 'name': run.name, 'frame_id': run.frame_id}
    number = number_of(connection, RUNS, values)
    cameras = [
        {
            'run_id': number,
            'bit': bit,
            'camera_id': number_of(connection, CAMERAS, {'site_id': site, 'name': name}),
        }
        for bit, name in enumerate(run.cameras)
    ]
    if cameras:
        connection.execute(insert(RUN_CAMERAS), cameras)
    return number, None


def find_run(connection: Connection, name: str) -> Row[Any]:
    """
    Return a run by its name, or the only one.

    Raises
    ------
    StoreError
        If there is none, or several and none is named.

    """
    asked = select(RUNS, SITES.c.name.label('site')).join(SITES, SITES.c.site_id == RUNS.c.site_id)
    found = connection.execute(asked.where(RUNS.c.name == name) if name else asked.limit(21)).all()
    if len(found) == 1:
        return found[0]
    if name or not found:
        raise StoreError(f'the database has no run {name}'.rstrip())
    listed = ', '.join(row.name for row in found[:20])
    raise StoreError(
        f'the database has several runs, name one (mctrack query DATABASE runs says when each '
        f'began): {listed}'
    )


def run_number(connection: Connection, name: str) -> int | None:
    """Return the number of a run, if there is one of that name."""
    return connection.execute(select(RUNS.c.run_id).where(RUNS.c.name == name)).scalar()


def newest_run(connection: Connection) -> str:
    """
    Return the name of the run that began last.

    Raises
    ------
    StoreError
        If none has tracks.

    """
    began = select(RUNS.c.name).where(RUNS.c.began_ns.is_not(None))
    found = connection.execute(began.order_by(RUNS.c.began_ns.desc()).limit(1)).scalar()
    if found is None:
        raise StoreError('the database has no run with tracks yet')
    return str(found)


def runs_that_say(connection: Connection, said: str, name: str) -> list[int]:
    """Return the runs of a name, with a number behind it or not, that `/site` gives another."""
    asked = (
        select(RUNS.c.run_id, RUNS.c.name, DESCRIPTIONS.c.text)
        .join(DESCRIPTIONS, DESCRIPTIONS.c.run_id == RUNS.c.run_id)
        .where(RUNS.c.name.startswith(name, autoescape=True))
    )
    numbered, found = re.compile(rf'{re.escape(name)}(-\d+)?'), set()
    for row in connection.execute(asked):
        if numbered.fullmatch(row.name) and _run_said(row.text) == said:
            found.add(row.run_id)
    return sorted(found)


def _run_said(text: str) -> Any:
    """Return what a text of `/site` calls its run; a stranger's may say anything."""
    try:
        return dict(json.loads(text)).get('run')
    except (ValueError, TypeError):
        return None


def number_of(connection: Connection, table: Table, values: dict[str, Any]) -> int:
    """Return the number of a row, which is made unless it is there."""
    key = next(iter(table.primary_key))
    asked = select(key).where(*(table.c[name] == value for name, value in values.items()))
    found = connection.execute(asked).scalar()
    if found is None:
        made = connection.execute(insert(table), values).inserted_primary_key
        assert made is not None
        found = made[0]
    return int(found)


def write_progress(connection: Connection, source: str, position: int, run: int) -> None:
    """Keep how far a source's messages are written, and into which run the last one."""
    values = {'position': position, 'run_id': run}
    statement = upsert(connection, PROGRESS).values(source=source, **values)
    connection.execute(statement.on_conflict_do_update(index_elements=['source'], set_=values))


def find_progress(connection: Connection, source: str) -> tuple[int, Row[Any] | None]:
    """Return how far a source's messages are written, and the run of the last one if there is."""
    joined = PROGRESS.outerjoin(RUNS, RUNS.c.run_id == PROGRESS.c.run_id)
    asked = select(PROGRESS.c.position, RUNS).select_from(joined)
    found = connection.execute(asked.where(PROGRESS.c.source == source)).one_or_none()
    if found is None:
        return 0, None
    return found.position, found if found.run_id is not None else None


def free_name(connection: Connection, wanted: str) -> str:
    """Return a name for a new run: that which is wanted, or the first free number behind it."""
    asked = select(RUNS.c.name).where(
        RUNS.c.name.startswith(wanted, autoescape=True),
        RUNS.c.began_ns.is_not(None) | RUNS.c.ended_ns.is_not(None),
    )
    taken = set(connection.execute(asked).scalars())
    numbered = (f'{wanted}-{number}' for number in count(2))
    return next(name for name in chain([wanted], numbered) if name not in taken)
