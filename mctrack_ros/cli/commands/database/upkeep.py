"""`mctrack store-check` and `mctrack forget`: whether a database is whole, and what goes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer

import typer

_DATABASE = typer.Argument(
    ..., help='Database: a file, or a URL such as postgresql://user@host/name.'
)


def store_check(database: str = _DATABASE) -> None:
    """Check that the tables of a trajectory database agree; each fault is a line, and exit 1."""
    from mctrack_ros.store import Database, check

    with Database(database) as opened:
        faults = check(opened)
    for line in faults:
        typer.echo(line)
    if faults:
        raise typer.Exit(1)
    typer.echo(f'{opened.name} is whole')


def forget(
    database: str = _DATABASE,
    track: int | None = typer.Option(
        None, min=1, help='Delete this track with all its traces, under all its ids.'
    ),
    whole_run: bool = typer.Option(False, '--whole-run', help='Delete a whole run.'),
    run: str = typer.Option('', help='Name of the run, if there are several.'),
    keep: str = typer.Option(
        '',
        help='Delete what is older, of all runs: 30d, or by kind positions=30d,events=90d,'
        'corrections=90d,videos=30d; units s, m, h, d.',
    ),
) -> None:
    """Delete somebody, a run, or what is too old, from a trajectory database."""
    from mctrack_ros.store import Database, Keep, forget_old, forget_run, forget_track
    from mctrack_ros.store.runs import find_run

    if (track is not None) + whole_run + bool(keep) != 1:
        raise typer.BadParameter('give one of --track, --whole-run and --keep')
    with _said_if_slow(), Database(database) as opened:
        if track is not None:
            found = forget_track(opened, track, run)
            typer.echo(f'deleted track {track}: {found.rows} rows, {found.events} events')
            if found.goes_on:
                typer.echo(
                    'it is in the last seconds of a run that is not finished: if a store writes '
                    'that run now, forget it again when the track has ended',
                    err=True,
                )
        elif whole_run:
            with opened.alone() as connection:
                row = find_run(connection, run)
                forget_run(connection, row.run_id)
            typer.echo(f'deleted run {row.name}')
        else:
            forgotten = forget_old(opened, Keep.parsed(keep), time.time_ns())
            for kind, count in forgotten.items():
                typer.echo(f'deleted {count} {kind}')
        opened.release()


@contextmanager
def _said_if_slow() -> Iterator[None]:
    """Say after two seconds what may take so long."""
    line = 'still at it: who else writes now is waited for, at most 30 s, and much takes its time'
    timer = Timer(2.0, typer.echo, [line], {'err': True})
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
