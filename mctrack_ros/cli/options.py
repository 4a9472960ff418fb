"""Options that several commands have, and checks before the work begins."""

from __future__ import annotations

import math
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from mctrack_ros.store.queries.run import Moment, Run

IMAGES = ('.png', '.svg', '.pdf')
HOST = typer.Option('127.0.0.1', help='Address of the page; any other needs --token.')
PORT = typer.Option(8080, min=1, max=65535, help='Port of the page.')
TOKEN = typer.Option(
    '',
    envvar='MCTRACK_TOKEN',
    help='Token that visitors enter; told by the variable, nobody sees it in a list of processes.',
)
BROWSER = typer.Option(True, '--browser/--no-browser', help='Open the page.')


def finite(value: float) -> float:
    """Refuse NaN and infinity."""
    if not math.isfinite(value):
        raise typer.BadParameter(f'{value} is no time, expected a number of seconds')
    return value


def _moment(text: str) -> Moment:
    """Read seconds, or a date in ISO 8601, which is UTC unless it says otherwise."""
    with suppress(ValueError):
        seconds = float(text)
        if math.isfinite(seconds):
            return seconds
    with suppress(ValueError):
        date = datetime.fromisoformat(text)
        return date if date.tzinfo else date.replace(tzinfo=UTC)
    raise typer.BadParameter(
        f'{text!r} is no time, expected seconds, or a date such as 2026-11-27T10:00'
    )


_TIME = "s since the run's first tick, or a date such as 2026-11-27T10:00, UTC"
FROM = typer.Option(None, '--from', parser=_moment, metavar='TIME', help=f'From when, {_TIME}.')
TO = typer.Option(None, '--to', parser=_moment, metavar='TIME', help='Until before when.')
AS_OF = typer.Option(
    None,
    '--as-of',
    parser=_moment,
    metavar='TIME',
    help='As it was known at that time; by default, as it is known now.',
)
AS_REPORTED = typer.Option(
    False, '--as-reported', help='With the ids of the time; no correction applies backwards.'
)
RUN = typer.Option('', '--run', help='Name of the run, if there are several.')


def times(run: Run, began: Moment | None, ended: Moment | None) -> tuple[float, float]:
    """Return from when until before when, s of a run; by default, from the first tick on."""
    from mctrack_ros.store.queries.run import ALWAYS

    first = 0.0 if began is None else run.since(began)
    last = ALWAYS[1] if ended is None else run.since(ended)
    if last <= first:
        raise typer.BadParameter(f'--to {ended} is not after --from {began or 0}')
    return first, last


def output_file(path: Path | None) -> Path | None:
    """Refuse a file in a folder that is not there: before the work, not after it."""
    if path is not None and not path.resolve().parent.is_dir():
        raise typer.BadParameter(f'{path}: there is no folder {path.resolve().parent}')
    return path


def image_file(path: Path | None) -> Path | None:
    """Refuse an image file with an unknown ending or a missing folder."""
    if path is not None and path.suffix.lower() not in IMAGES:
        raise typer.BadParameter(f'{path} ends in {path.suffix!r}, expected {", ".join(IMAGES)}')
    return output_file(path)
