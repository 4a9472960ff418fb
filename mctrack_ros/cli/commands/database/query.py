"""`mctrack query`: ask a trajectory database."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, make_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Any, get_type_hints

import typer

from mctrack_ros.cli import options

app = typer.Typer(no_args_is_help=True)
_ENDINGS = {
    '.json': 'json',
    '.geojson': 'geojson',
    '.csv': 'csv',
    '.parquet': 'parquet',
    '.txt': 'table',
}
_WIDTH = 10_000  # rows are not broken; a terminal or `less -S` does what it does
_POINTS = 'Points as x,y in m, parted by blanks: "0,0 4,0 4,3".'


@app.callback()
def _root(
    context: typer.Context,
    database: str = typer.Argument(
        ...,
        help='Database (a file, or a URL such as postgresql://user@host/name), or bag, or what '
        '`mctrack track` wrote.',
    ),
) -> None:
    """Ask a trajectory database."""
    context.obj = database


_FORM = typer.Option(
    '',
    '--format',
    help='table, json, geojson, csv or parquet; by default as --out ends, or a table.',
)
_OUT = typer.Option(
    None,
    callback=options.output_file,
    help='File to write: .json, .geojson, .csv, .parquet, .txt; unless given, it is printed.',
)


def _common(
    run: str = typer.Option(
        '', help='Name of the run, if there are several; "match*" asks all that begin so.'
    ),
    began: Any = options.FROM,
    ended: Any = options.TO,
    as_of: Any = options.AS_OF,
    as_reported: bool = options.AS_REPORTED,
    form: str = _FORM,
    out: Path | None = _OUT,
) -> None:
    """Name the options of every question."""


def _question(ask: Callable[..., Any]) -> Callable[..., Any]:
    """Make a command of a question, which returns rows and their type, with the options of all."""
    hints = get_type_hints(ask) | get_type_hints(_common) | {'context': typer.Context}
    own = list(signature(ask).parameters.values())[2:]
    common = list(signature(_common).parameters.values())
    listed = [Parameter('context', Parameter.POSITIONAL_OR_KEYWORD), *own, *common]

    @wraps(ask)
    def command(**given: Any) -> None:
        from mctrack_ros.store import View
        from mctrack_ros.store.exchange import opened_runs

        database = given.pop('context').obj
        said = {each.name: given.pop(each.name) for each in common}
        form = _format(said['form'], said['out'])
        view = View(corrected=not said['as_reported'])
        with opened_runs(database, said['run'], view) as runs:
            answers = {}
            for run in runs:
                if said['as_of'] is not None:
                    run.view = View(run.since(said['as_of']), view.corrected)
                between = options.times(run, said['began'], said['ended'])
                rows, kind = ask(run, between, **given)
                answers[run.name] = rows
            track = given.get('track')
            if not any(answers.values()) and track is not None and len(runs) == 1:
                _check_track(run, track)
        if len(answers) > 1:
            rows, kind = _of_several(answers, kind)
        _answer(rows, kind, form, said['out'])

    shown = [each.replace(annotation=hints[each.name]) for each in listed]
    command.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    command.__annotations__ = {each.name: hints[each.name] for each in listed}
    return command


@app.command('runs')
def _runs(context: typer.Context, form: str = _FORM, out: Path | None = _OUT) -> None:
    """Show all runs of the database: when they began and how long they are."""
    from mctrack_ros.store import Database, runs
    from mctrack_ros.store.queries.results import RunSummary

    form = _format(form, out)
    with Database(context.obj) as database:
        _answer(runs(database), RunSummary, form, out)


@app.command('tracks')
@_question
def _tracks(
    run: Any, between: Any, track: int | None = typer.Option(None, help='Only this one.')
) -> tuple[Sequence[Any], Any]:
    """Show all tracks: when they were there, how far they went and how fast."""
    from mctrack_ros.store import summaries
    from mctrack_ros.store.queries.results import TrackSummary

    return summaries(run, between, track), TrackSummary


@app.command('trajectory')
@_question
def _trajectory(
    run: Any, between: Any, track: int = typer.Argument(..., help='Its id.')
) -> tuple[Sequence[Any], Any]:
    """Show where a track was."""
    from mctrack_ros.store import trajectory
    from mctrack_ros.store.queries.results import Place

    return trajectory(run, track, between), Place


@app.command('near')
@_question
def _near(
    run: Any,
    between: Any,
    whom: str = typer.Argument(..., help='Id of a track, or a point as x,y in m.'),
    within: float = typer.Option(3.0, min=0.0, help='How near, m.'),
) -> tuple[Sequence[Any], Any]:
    """Show who was near a track or a point."""
    from mctrack_ros.store import near
    from mctrack_ros.store.queries.results import Visit

    place = _points(whom)[0] if ',' in whom else _id(whom)
    found = near(run, place, within, between)
    if not found and isinstance(place, int):
        _check_track(run, place)
    return found, Visit


@app.command('meetings')
@_question
def _meetings(
    run: Any,
    between: Any,
    within: float = typer.Option(1.5, min=0.0, help='Who is nearer meets, m.'),
    least: float = typer.Option(0.0, min=0.0, help='Shorter meetings are left out, s.'),
    track: int | None = typer.Option(None, help='Only meetings of this one.'),
) -> tuple[Sequence[Any], Any]:
    """Show who met whom."""
    from mctrack_ros.store import meetings
    from mctrack_ros.store.queries.results import Meeting

    return meetings(run, within, least, between, track), Meeting


@app.command('events')
@_question
def _events(
    run: Any,
    between: Any,
    kind: list[str] = typer.Option([], help='Only these: new, exit, merge, split, ...'),
    area: str = typer.Option('', help=f'Only in this polygon. {_POINTS}'),
    track: int | None = typer.Option(None, help='Only those that concern this one.'),
) -> tuple[Sequence[Any], Any]:
    """Show events."""
    from mctrack_ros.interfaces import EventCode
    from mctrack_ros.store import events
    from mctrack_ros.store.queries.results import Event

    names = EventCode.__members__
    for each in kind:
        if each.upper() not in names:
            raise typer.BadParameter(f'{each!r} is no event: {", ".join(names).lower()}')
    kinds = [names[each.upper()] for each in kind]
    return events(run, kinds, _points(area), between, track), Event


@app.command('crossings')
@_question
def _crossings(
    run: Any,
    between: Any,
    points: str = typer.Argument('', help=_POINTS),
    line: str = typer.Option('', help='Name of a line of the site, instead of points.'),
    per: float = typer.Option(60.0, min=0.001, help='Length of a period, s.'),
) -> tuple[Sequence[Any], Any]:
    """Count who crosses a line, to its left and to its right."""
    from mctrack_ros.store import crossings
    from mctrack_ros.store.queries.results import Crossings

    given = _named(run.zones().lines, line, points)
    return crossings(run, given, between, per), Crossings


@app.command('occupancy')
@_question
def _occupancy(
    run: Any,
    between: Any,
    points: str = typer.Argument('', help=_POINTS),
    zone: str = typer.Option('', help='Name of a zone of the site, instead of points.'),
    per: float = typer.Option(60.0, min=0.001, help='Length of a period, s.'),
) -> tuple[Sequence[Any], Any]:
    """Count who is in an area."""
    from mctrack_ros.store import occupancy
    from mctrack_ros.store.queries.results import Occupancy

    given = _named(run.zones().zones, zone, points)
    return occupancy(run, given, between, per), Occupancy


@app.command('heat-map')
@_question
def _heat_map(
    run: Any,
    between: Any,
    cell: float = typer.Option(1.0, min=0.01, help='Side of a square, m.'),
    area: str = typer.Option('', help=f'Only in this polygon. {_POINTS}'),
    track: int | None = typer.Option(None, help='Only this one.'),
) -> tuple[Sequence[Any], Any]:
    """Show how long somebody was where."""
    from mctrack_ros.store import heat_map
    from mctrack_ros.store.queries.results import Cell

    return heat_map(run, cell, between, _points(area), track), Cell


@app.command('videos')
@_question
def _videos(
    run: Any, between: Any, track: int = typer.Argument(..., help='Its id.')
) -> tuple[Sequence[Any], Any]:
    """Show which videos show a track, and where in them."""
    from mctrack_ros.store import showings
    from mctrack_ros.store.queries.results import Showing

    return showings(run, track, between), Showing


def _format(form: str, out: Path | None) -> str:
    """Return the format of an answer."""
    from mctrack_ros.store.queries.output import Format

    if not form and out is not None and out.suffix.lower() not in _ENDINGS:
        raise typer.BadParameter(f'{out} ends in none of {", ".join(_ENDINGS)}: give --format')
    form = form or (_ENDINGS[out.suffix.lower()] if out else 'table')
    if form not in list(Format):
        raise typer.BadParameter(f'--format is {form!r}, expected {", ".join(Format)}')
    if form == Format.PARQUET and out is None:
        raise typer.BadParameter('a Parquet file needs a name: --out FILE')
    return form


def _answer(rows: Sequence[Any], kind: Any, form: str, out: Path | None) -> None:
    """Print an answer, or write it."""
    from mctrack_ros.store.queries import output

    if form == 'parquet' and out is not None:
        output.write_parquet(rows, kind, out)
    elif form == 'table':
        _show_table(rows, kind, out)
    else:
        made = {'json': output.as_json, 'geojson': output.as_geojson}.get(form)
        text = made(rows) if made else output.as_csv(rows, kind)
        if out is None:
            typer.echo(text.rstrip('\n'))
        else:
            out.write_text(text)
    if out is not None:
        typer.echo(f'wrote {out}: {len(rows)} rows')


def _show_table(rows: Sequence[Any], kind: Any, out: Path | None) -> None:
    """Print a table, or write it."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from mctrack_ros.store.queries.output import cells

    table = Table(box=box.SIMPLE_HEAD)
    for field in fields(kind):
        table.add_column(field.name, justify='right', no_wrap=True)
    for row in rows:
        table.add_row(*cells(row))
    if out is None:
        Console(width=_WIDTH).print(table)
        return
    with out.open('w') as file:
        Console(file=file, width=_WIDTH).print(table)


def _named(known: Sequence[Any], name: str, points: str) -> Any:
    """Return a zone or line of the site by its name, or else the points that are given."""
    if bool(name) == bool(points):
        raise typer.BadParameter('give either points or a name')
    if points:
        return _points(points)
    found = [each for each in known if each.name == name]
    if not found:
        names = ', '.join(each.name for each in known) or 'none'
        raise typer.BadParameter(f'the site has no {name!r}, but {names}')
    return found[0]


def _points(text: str) -> list[tuple[float, float]]:
    """Read points, m."""
    found = []
    for each in text.split():
        try:
            x, y = map(float, each.split(','))
            found.append((options.finite(x), options.finite(y)))
        except ValueError as error:
            raise typer.BadParameter(f'{each!r} is no point, expected x,y') from error
    return found


def _check_track(run: Any, track: int) -> None:
    """Refuse an id that is nobody's: that nothing was found would mislead."""
    from mctrack_ros.store import StoreError
    from mctrack_ros.store.queries.tracks import called_now

    now = called_now(run, track)
    if not now:
        raise StoreError(f'run {run.name} has no track {track}')
    if track not in now:
        names = ' and '.join(map(str, now))
        raise StoreError(
            f'track {track} is called {names} now; --as-reported takes ids of the time'
        )


def _of_several(
    answers: Mapping[str, Sequence[Any]], kind: type[Any]
) -> tuple[Sequence[Any], type[Any]]:
    """Return the answers of several runs with the run's name before each row, and their type."""
    columns = [('run', str), *((field.name, field.type) for field in fields(kind))]
    named = make_dataclass(kind.__name__, columns, frozen=True)
    return [
        named(run, *(getattr(row, field.name) for field in fields(kind)))
        for run, rows in answers.items()
        for row in rows
    ], named


def _id(text: str) -> int:
    try:
        return int(text)
    except ValueError as error:
        raise typer.BadParameter(f'{text!r} is neither an id nor a point x,y') from error
