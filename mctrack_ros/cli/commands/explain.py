"""`mctrack explain`: why a track is what it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.cli.options import finite, image_file
from mctrack_ros.site.names import namespace_of

if TYPE_CHECKING:
    from mctrack_ros.explain import TrackHistory

_TABLE_WIDTH = 10_000  # rows are not broken; a terminal or `less -S` does what it does


def explain(
    bag: Path = typer.Argument(..., help='Bag with the detections of every camera.'),
    track: int = typer.Option(..., '--track', min=1, help='Id of the track.'),
    at: float = typer.Option(
        ..., '--at', callback=finite, help="When, since the bag's first tick, s."
    ),
    length: float = typer.Option(
        0.0,
        '--for',
        min=0.0,
        callback=finite,
        help='Also print what changed in the time after it, s.',
    ),
    site: str = typer.Option(
        '', help='Site YAML, or the name of a shipped site; unless given, what the bag says.'
    ),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the topics in the bag, for example /hall.'
    ),
    out: Path | None = typer.Option(
        None, callback=image_file, help='Image to write, for example why.png.'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write all numbers here.'),
) -> None:
    """Say why a track took its detections, coasted, changed its id, began or ended."""
    from mctrack_ros.cli.sites import camera_site
    from mctrack_ros.explain import course, draw_explanation, history_of, sentences, write_history

    history = history_of(bag, track, at, length, camera_site(site) if site else None, namespace)
    for sentence in sentences(history):
        typer.echo(sentence)
    _show_candidates(history)
    changes = list(course(history))
    for line in changes:
        typer.echo(line)
    if length and not changes:
        last_s = history.seconds(history.explanations[-1].stamp_ns)
        typer.echo(f'Nothing changed for it until {last_s:.3f} s.')
    typer.echo('From the explanations in the bag.' if history.is_stored else 'Fused again.')
    if out is not None:
        draw_explanation(history, out)
        typer.echo(f'wrote {out}')
    if json_file is not None:
        write_history(history, json_file)


def _show_candidates(history: TrackHistory) -> None:
    """Print the detections that came into question, if any did."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from mctrack_ros.explain import COLUMNS, candidate_rows

    table = Table(*COLUMNS, box=box.SIMPLE_HEAD)
    for column in table.columns[1:-1]:
        column.justify = 'right'
    for row in candidate_rows(history):
        table.add_row(*row)
    if table.row_count:
        Console(width=_TABLE_WIDTH).print(table)
        typer.echo(
            'distance², clutter, colours and doubt add up to the cost: -2 log '
            f"of the likelihood ratio against nobody's. The gate is {history.gate:g}."
        )
