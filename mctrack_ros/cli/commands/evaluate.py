"""`mctrack evaluate`: tracks against truth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from mctrack_ros.evaluation.selection import Selection

_JSON = typer.Option(None, '--json', help='Also write the figures here.')


def evaluate(
    truth: Path = typer.Argument(
        ..., help='Bag with /truth/tracks, MOT text, or CSV with a header.'
    ),
    tracks: Path = typer.Argument(
        ..., help='Bag with /tracks, MOT text, CSV with a header, or what track wrote.'
    ),
    gate: float = typer.Option(1.0, min=1e-6, help='Largest distance of a match, m.'),
    area: str = typer.Option(
        '',
        help='Score only this area: x0,y0,x1,y1 or the corners x,y of a polygon, m '
        '(--area=-1,0,5,9 where it begins with a minus).',
    ),
    start: float | None = typer.Option(
        None, '--from', help='Score from here on, s since the tracks begin.'
    ),
    stop: float | None = typer.Option(
        None, '--to', help='Score until before this, s since the tracks begin.'
    ),
    kind: str = typer.Option(
        '', '--class', help='Score only these: person, vehicle, bicycle, ball.'
    ),
    rate: float | None = typer.Option(
        None,
        min=0.001,
        max=1000.0,
        help='Frames a second of text; by default those of the other file, or 25.',
    ),
    json_file: Path | None = _JSON,
) -> None:
    """Score tracks against truth on the ground plane, and list the switches of identity."""
    from mctrack_ros.cli.tables import show_figures
    from mctrack_ros.evaluation.comparison import Comparison

    comparison = Comparison.read(truth, tracks, _selection(area, start, stop, kind), rate)
    show_figures(comparison.figures(gate), json_file)
    if comparison.note:
        typer.echo(f'\n{comparison.note}')
    lines = comparison.switch_lines(gate)
    if lines:
        typer.echo('\nidentity switches: true id, its old and its new track')
    for line in lines:
        typer.echo(line)


def _selection(area: str, start: float | None, stop: float | None, kind: str) -> Selection:
    """Return the selection that the options describe."""
    from mctrack_ros.evaluation.selection import Selection
    from mctrack_ros.ground.coverage.coverage import area_from
    from mctrack_ros.interfaces import ClassCode

    if area:
        area_from(area)
    first, last = -math.inf if start is None else start, math.inf if stop is None else stop
    if not first < last:
        raise ValueError(f'--from {first:g} is not before --to {last:g}')
    codes = {code.name.lower(): code for code in ClassCode}
    if kind and kind not in codes:
        raise ValueError(f'--class is {kind!r}, expected one of {", ".join(codes)}')
    return Selection(area, first, last, codes.get(kind))
