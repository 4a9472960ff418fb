"""Commands that compare: evaluate, results."""

from __future__ import annotations

from pathlib import Path

import typer

_JSON = typer.Option(None, '--json', help='Also write the figures here.')
_FOLDER = typer.Option(Path('docs/results'), help='Folder of the JSON files.')
_PAGE = typer.Option(Path('docs/results.md'), help='The page to write.')


def evaluate(
    truth: Path = typer.Argument(..., help='Bag with /truth/tracks, or MOT text.'),
    tracks: Path = typer.Argument(..., help='Bag with /tracks, MOT text, or what track wrote.'),
    gate: float = typer.Option(1.0, min=1e-6, help='Largest distance of a match, m.'),
    json_file: Path | None = _JSON,
) -> None:
    """Score tracks against truth on the ground plane, and list the switches of identity."""
    from mctrack_ros.experiments.comparison import Comparison

    comparison = Comparison.read(truth, tracks)
    figures = comparison.figures(gate)
    typer.echo(figures.table())
    if comparison.note:
        typer.echo(f'\n{comparison.note}')
    lines = comparison.switch_lines(gate)
    if lines:
        typer.echo('\nidentity switches: true id, its old and its new track')
    for line in lines:
        typer.echo(line)
    if json_file is not None:
        figures.write(json_file)


def results(folder: Path = _FOLDER, page: Path = _PAGE) -> None:
    """Write the page of results from the figures measured."""
    from mctrack_ros.experiments.results import write_results

    write_results(folder, page)
    typer.echo(f'wrote {page}')
