"""`mctrack results`: the page of results."""

from __future__ import annotations

from pathlib import Path

import typer

_FOLDER = typer.Option(Path('docs/results'), help='Folder of the JSON files.')
_PAGE = typer.Option(Path('docs/results.md'), help='The page to write.')


def results(folder: Path = _FOLDER, page: Path = _PAGE) -> None:
    """Write the page of results from the figures measured."""
    from mctrack_experiments.results import write_results

    write_results(folder, page)
    typer.echo(f'wrote {page}')
