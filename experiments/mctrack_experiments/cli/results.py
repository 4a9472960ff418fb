"""`mctrack results`: the page of results."""

from __future__ import annotations

from pathlib import Path

import typer

from mctrack_experiments.cli.options import RUNS

_FOLDER = typer.Option(Path('docs/results'), help='Folder of the JSON files.')
_PAGE = typer.Option(Path('docs/results.md'), help='The page to write.')


def results(folder: Path = _FOLDER, runs: Path = RUNS, page: Path = _PAGE) -> None:
    """Write the page of results from the figures measured."""
    from mctrack_experiments.results import write_results

    write_results(folder, runs, page)
    typer.echo(f'wrote {page}')
