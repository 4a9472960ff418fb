"""Options that several commands have, and checks before the work begins."""

from __future__ import annotations

import math
from pathlib import Path

import typer

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


def times(began: float, ended: float | None) -> tuple[float, float]:
    """Return from when until before when, s; without an end, until after all."""
    from mctrack_ros.store.queries.run import ALWAYS

    if ended is None:
        return began, ALWAYS[1]
    if finite(ended) <= began:
        raise typer.BadParameter(f'--to {ended:g} is not after --from {began:g}')
    return began, ended


def image_file(path: Path | None) -> Path | None:
    """Refuse an image file with an unknown ending or a missing folder."""
    if path is not None and path.suffix.lower() not in IMAGES:
        raise typer.BadParameter(f'{path} ends in {path.suffix!r}, expected {", ".join(IMAGES)}')
    if path is not None and not path.resolve().parent.is_dir():
        raise typer.BadParameter(f'{path}: there is no folder {path.resolve().parent}')
    return path
